"""Units of FMI made here from a few lines of C, as other tools make them."""

import shutil
import subprocess
import zipfile

import pytest

fmpy = pytest.importorskip("fmpy")

STAIR = """
static int count; static double next_event;
static void begin(void) { count = 1; next_event = 1.0; }
static int step(void) { return to > next_event + 1e-12 ? 3 : 0; }
static bool at_event(double* next) {
  while (t >= next_event - 1e-12) { count++; next_event += 1.0; }
  *next = next_event; return true; }
static void output(void) { v[0] = count; }
"""

FEEDTHROUGH = """
static void begin(void) { memset(v, 0, sizeof v); v[4] = 2.0; v[5] = 1.0; }
static int step(void) { return 0; }
static bool at_event(double* next) { return false; }
static void output(void) {
  for (int i = 0; i < 4; i++) v[10 + i] = v[4] * v[i];
  v[14] = v[6]; v[15] = v[7]; v[16] = v[5]; v[17] = strcmp(word, "given") == 0;
  for (int i = 0; i < 3; i++) v[20 + i] = v[30 + i] + i; }
"""
SIGNALS = """
<Float64 name="speed" valueReference="0" causality="input" unit="rpm" start="0"/>
<Float64 name="temperature" valueReference="1" causality="input" unit="degC" start="0"/>
<Float64 name="moment" valueReference="2" causality="input" unit="kNm" start="0"/>
<Float64 name="plain" valueReference="3" causality="input" start="0"/>
<Float64 name="axis.k[1]" valueReference="4" causality="parameter" variability="fixed" start="2"/>
<Int32 name="mode" valueReference="5" causality="parameter" variability="fixed" start="1"/>
<Boolean name="on" valueReference="6" causality="input" start="false"/>
<Int32 name="gear" valueReference="7" causality="input" start="0"/>
<String name="label" valueReference="8" causality="parameter" variability="fixed">
<Start value="none"/></String>
<Float64 name="speed out" valueReference="10" causality="output" unit="rpm"/>
<Float64 name="temperature out" valueReference="11" causality="output" unit="degC"/>
<Float64 name="moment out" valueReference="12" causality="output" unit="kNm"/>
<Float64 name="plain out" valueReference="13" causality="output"/>
<Boolean name="is on" valueReference="14" causality="output"/>
<Int32 name="gear out" valueReference="15" causality="output"/>
<Int32 name="mode out" valueReference="16" causality="output"/>
<Int32 name="is given" valueReference="17" causality="output"/>
<Float64 name="three out" valueReference="20" causality="output"><Dimension start="3"/></Float64>
<Float64 name="three" valueReference="30" causality="input" start="0 0 0">
<Dimension start="3"/></Float64>
"""
UNITS = """<UnitDefinitions>
<Unit name="rpm"><BaseUnit s="-1" rad="1" factor="0.10471975511965977"/></Unit>
<Unit name="degC"><BaseUnit K="1" offset="273.15"/></Unit>
<Unit name="kNm"><BaseUnit kg="1" m="2" s="-2" factor="1000"/></Unit>
</UnitDefinitions>"""

_HEAD = {
    "3.0": """
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
typedef void (*Log)(void*, int, const char*, const char*);
static double t, to, v[64];
static Log tell;
static int size_of(uint32_t r) { return r == ARRAY ? 3 : 1; }
static void begin(void); static int step(void); static void output(void);
static bool at_event(double* next);
void* fmi3InstantiateCoSimulation(const char* a, const char* b, const char* c, bool d, bool e,
    bool f, bool g, const uint32_t* h, size_t i, void* j, Log log, void* k) {
  tell = log; begin(); return v; }
void fmi3FreeInstance(void* c) {}
int fmi3EnterInitializationMode(void* c, bool a, double b, double start, bool d, double e) {
  t = start; return 0; }
int fmi3ExitInitializationMode(void* c) { return 0; }
int fmi3EnterEventMode(void* c) { return 0; }
int fmi3EnterStepMode(void* c) { return 0; }
int fmi3Reset(void* c) { begin(); return 0; }
int fmi3UpdateDiscreteStates(void* c, bool* again, bool* ends, bool* n, bool* x, bool* has_next,
    double* next) {
  *again = *ends = *n = *x = false; *has_next = at_event(next); return 0; }
int fmi3DoStep(void* c, double now, double h, bool a, bool* event, bool* ends, bool* early,
    double* last) {
  *event = *ends = *early = false; to = now + h; int status = step(); t = *last = to;
  if (status == -1) { *ends = true; return 0; }
  return status; }
#define ACCESS(Name, Type) \\
int fmi3Get##Name(void* c, const uint32_t* r, size_t n, Type* x, size_t m) { \\
  output(); size_t k = 0; \\
  for (size_t i = 0; i < n; i++) \\
    for (int j = 0; j < size_of(r[i]); j++) x[k++] = (Type)v[r[i] + j]; \\
  return 0; } \\
int fmi3Set##Name(void* c, const uint32_t* r, size_t n, const Type* x, size_t m) { \\
  size_t k = 0; \\
  for (size_t i = 0; i < n; i++) \\
    for (int j = 0; j < size_of(r[i]); j++) v[r[i] + j] = x[k++]; \\
  return 0; }
ACCESS(Float64, double) ACCESS(Float32, float) ACCESS(Int32, int32_t) ACCESS(Int64, int64_t)
ACCESS(Boolean, bool)
static char word[64] = "";
int fmi3SetString(void* c, const uint32_t* r, size_t n, const char* const* x, size_t m) {
  strncpy(word, x[0], 63); return 0; }
""",
    "2.0": """
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
typedef void (*Log)(void*, const char*, int, const char*, const char*, ...);
static double t, to, v[64];
static Log tell;
static void begin(void); static int step(void); static void output(void);
void* fmi2Instantiate(const char* a, int kind, const char* c, const char* d, const void* callbacks,
    int e, int f) {
  tell = *(const Log*)callbacks; begin(); return v; }
void fmi2FreeInstance(void* c) {}
int fmi2SetupExperiment(void* c, int a, double b, double start, int d, double e) {
  t = start; return 0; }
int fmi2EnterInitializationMode(void* c) { return 0; }
int fmi2ExitInitializationMode(void* c) { return 0; }
int fmi2Reset(void* c) { begin(); return 0; }
int fmi2DoStep(void* c, double now, double h, int a) {
  to = now + h; int status = step(); t = to; return status; }
#define ACCESS(Name, Type) \\
int fmi2Get##Name(void* c, const unsigned* r, size_t n, Type* x) { \\
  output(); for (size_t i = 0; i < n; i++) x[i] = (Type)v[r[i]]; return 0; } \\
int fmi2Set##Name(void* c, const unsigned* r, size_t n, const Type* x) { \\
  for (size_t i = 0; i < n; i++) v[r[i]] = x[i]; return 0; }
ACCESS(Real, double) ACCESS(Integer, int) ACCESS(Boolean, int)
""",
}

_OPEN = (
    '<fmiModelDescription fmiVersion="{version}" modelName="{name}" {token}="{{1}}">'
    '<CoSimulation modelIdentifier="{name}" {flags}/>{units}'
    '<DefaultExperiment stepSize="0.01"/>'
)


def c_unit(folder, name, variables, code, *, version="3.0", flags="", units="", arrays=()):
    """A unit for co-simulation.

    The code finds these, and may use what `_HEAD` includes:

    * ``v``: values of all variables by their references, below 64; in version 3 the time is the
      variable 63, which is added here;
    * ``t``, ``to``: the time, and the end of a step;
    * ``tell``: how the unit logs; ``word``: the string that was set last (version 3).

    It defines:

    * ``void begin(void)``: values when the unit is made or reset;
    * ``int step(void)``: a step from ``t`` to ``to``; its status, or in version 3 -1 to end the
      simulation; it may lower ``to`` where it stops;
    * ``void output(void)``: what follows from inputs, before values are read;
    * ``bool at_event(double* next)`` (version 3): an event, and the instant of the next.

    All other functions of the standard fail, with status 3.

    Parameters
    ----------
    variables : str
        Elements of the model description; the value reference of each is its place in ``v``.
    code : str
        In C, as above.
    flags, units : str
        Attributes of its kind; definitions of units.
    arrays : sequence of int
        References of variables with three values.
    """
    if shutil.which("cc") is None:
        pytest.skip("there is no C compiler")
    text = _write_source(version, code, arrays)
    xml = _describe(name, variables, version, flags, units)
    return _pack(folder, name, version, xml, _compile(folder, name, text))


def _write_source(version, code, arrays):
    is_array = "".join(f" || r == {reference}" for reference in arrays)
    text = _HEAD[version].replace("r == ARRAY", f"0{is_array}") + code
    prefix = f"fmi{version[0]}"
    unit = getattr(getattr(fmpy, prefix), f"FMU{version[0]}Slave")
    accesses = {f"{prefix}{way}{kind}" for way in ("Get", "Set") for kind in _KINDS}
    missing = [n for n in dir(unit) if n.startswith(prefix) and f" {n}(" not in text]
    return text + "".join(f"int {n}(void) {{ return 3; }}\n" for n in missing if n not in accesses)


def _describe(name, variables, version, flags, units):
    token = "instantiationToken" if version == "3.0" else "guid"
    xml = _OPEN.format(version=version, token=token, name=name, flags=flags, units=units)
    variables += _TIME if version == "3.0" else ""
    return (
        f"{xml}<ModelVariables>{variables}</ModelVariables><ModelStructure/></fmiModelDescription>"
    )


def _compile(folder, name, text):
    source, made = folder / f"{name}.c", folder / f"{name}.so"
    source.write_text(text)
    subprocess.run(["cc", "-w", "-shared", "-fPIC", "-o", made, source], check=True)
    return made


def _pack(folder, name, version, xml, made):
    path = folder / f"{name}.fmu"
    place = fmpy.platform_tuple if version == "3.0" else fmpy.platform
    with zipfile.ZipFile(path, "w") as held:
        held.writestr("modelDescription.xml", xml)
        held.write(made, f"binaries/{place}/{name}{fmpy.sharedLibraryExtension}")
    return path


_TIME = '<Float64 name="t" valueReference="63" causality="independent" variability="continuous"/>'
_KINDS = ("Float64", "Float32", "Int32", "Int64", "Boolean", "Real", "Integer")
