// What the page does with news of the server: kind, model and value of each.
const read = window.lumpedPage ??= (() => {
  // Bokeh writes the styles of axes at each painting; the browser would find equal ones anew
  try {
    const {InlineStyleSheet: {prototype}} = Bokeh.require("core/dom")
    const {replace} = prototype
    prototype.replace = function(css, styles) {
      if (styles != null || css != this.css) replace.call(this, css, styles)
    }
  } catch {}  // another version of Bokeh, without them
  const figures = new Map()
  const hold = (figure, is_held) => figure.setv({hold_render: is_held}, {sync: false})
  const seen = new IntersectionObserver((entries) => {
    for (const {target, isIntersecting} of entries) hold(figures.get(target), !isIntersecting)
  }, {rootMargin: "100px"})
  addEventListener("beforeprint", () => figures.forEach((figure) => hold(figure, false)))
  const root = (div) => Bokeh.index.find_one(div)?.shadow_el
  return {
    data: (source, columns) => source.setv({data: columns}, {sync: false}),
    html: (div, text) => {
      const place = root(div)?.querySelector(".bk-clearfix")
      if (place != null) place.innerHTML = text
      else div.setv({text}, {sync: false})  // it is still being built
    },
    texts: (div, {id, text}) => id.forEach((each, i) => {
      const told = root(div)?.getElementById(each)?.querySelector("text")
      if (told != null && told.textContent != text[i]) told.textContent = text[i]
    }),
    figure(figure) {
      const {el} = Bokeh.index.find_one(figure) ?? {}
      if (el == null) setTimeout(() => this.figure(figure), 50)  // it is still being built
      else if (!figures.has(el)) { figures.set(el, figure); seen.observe(el) }
    },
    link: (_, query) => history.replaceState(null, "", "?" + query),
    file: (_, {name, text}) => {
      const link = document.createElement("a")
      link.href = URL.createObjectURL(new Blob([text], {type: "text/plain"}))
      link.download = name
      link.click()
    },
  }
})()
for (const [kind, id, value] of cb_obj.data.news[0]) {
  const model = cb_obj.document.get_model_by_id(id)
  if (model != null) read[kind](model, value)
}
