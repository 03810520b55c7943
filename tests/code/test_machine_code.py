"""Machine code that is linked, and let go of."""

import gc
import weakref

from lumped.code.machine_code import load_or_compile


def linked(k):
    text = f"define i32 @number() {{ ret i32 {k} }}"
    return load_or_compile(text, lambda: (text,))


def test_code_that_nobody_uses_is_freed_only_when_code_is_linked_again():
    code = linked(41)
    code.itself = code  # only the collector of garbage finds it
    engine = weakref.ref(code._engine)
    del code
    gc.collect()
    assert engine() is not None
    linked(42)
    assert engine() is None
