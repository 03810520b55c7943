import pytest
from rows import in_a_row

import lumped as lp
from lumped.components import Inertia, Spring, SpringDamper, Torque
from lumped.errors import ConnectError, DeclarationError, UnitError


class Stage(lp.Component):
    """Shaft and rotor with parameters of their own level: c_shaft = 2 c."""

    c: lp.Param = lp.param("N.m/rad", "stiffness of half the shaft", 50.0)
    shaft: SpringDamper = SpringDamper(c=2 * c, d=c / 100)
    rotor: Inertia = Inertia(J=1.0)

    def connections(self):
        yield from lp.chain(self.shaft, self.rotor)


class Train(lp.Component):
    """A source, stages in a list and named ends in a dictionary: w = w."""

    n: int = 2
    source: Inertia = Inertia(J=1.0)
    shafts = [Spring(c=100.0), Spring(c=200.0)]  # noqa: RUF012
    ends = {"left": Inertia(J=2.0), "right": Inertia(J=3.0)}  # noqa: RUF012

    def connections(self):
        yield from lp.chain(self.ends["left"], self.shafts[0], self.source)
        yield from lp.chain(self.source, self.shafts[1], self.ends["right"])


def test_lists_and_dictionaries_of_parts_have_dotted_names():
    system = lp.assemble(Train())
    assert {'ends["left"].w', "shafts[1].phi_rel", "source.w"} <= set(system.state_names)
    run = lp.simulate(system, until=1.0, start={'ends["left"].w': 1.0}, grid=4)
    rig = Train()
    assert (run[rig.ends["left"].w] == run['ends["left"].w']).all()


def test_a_bound_parameter_follows_its_parents_parameter():
    class Rig(lp.Component):
        """Two stages: c = c."""

        anchor: Inertia = Inertia(J=1.0)
        stage: Stage = Stage(c=70.0)

        def connections(self):
            yield lp.connect(self.anchor.flange_b, self.stage.shaft.flange_a)

    class Wired(Rig):
        """The same, joined through a port of the stage: phi = phi."""

        def connections(self):
            yield lp.connect(self.anchor.flange_b, self.stage.rotor.flange_b)

    with pytest.raises(ConnectError, match=r"stage\.shaft\.flange_a"):
        lp.assemble(Rig())
    with pytest.raises(ConnectError, match="direct parts"):
        lp.assemble(Wired())


def test_changing_a_parents_parameter_changes_every_use():
    class Ported(Stage):
        """Stage with a port: phi = phi."""

        port = lp.Flange()

        def connections(self):
            yield from super().connections()
            yield lp.connect(self.port, self.shaft.flange_a)

    class Rig(lp.Component):
        """One stage: c = c."""

        anchor: Inertia = Inertia(J=1.0)
        stage: Ported = Ported()

        def connections(self):
            yield lp.connect(self.anchor.flange_b, self.stage.port)

    system = lp.assemble(Rig())
    linear = lp.linearise(system, parameters={"stage.c": 80.0})
    row = linear.states.index("anchor.w")
    columns = [linear.states.index(n) for n in ("stage.shaft.phi_rel", "stage.rotor.w")]
    received = linear.A[row, columns]
    expected = [2 * 80.0, 80.0 / 100]
    assert received == pytest.approx(expected, rel=1e-15)


def test_one_instance_stands_in_two_models():
    body = Inertia(J=3.0)
    models = [in_a_row(drive=Torque(tau=tau), body=body) for tau in (6.0, 9.0)]
    received = [lp.simulate(lp.assemble(m), until=1.0, grid=1)["body.w"][-1] for m in models]
    assert received == pytest.approx([2.0, 3.0], rel=1e-12)


def test_compose_takes_references_to_the_objects_it_is_given():
    motor, shaft, load = Inertia(J=1.0), Spring(c=4.0), Inertia(J=1.0)
    model = lp.compose(
        motor=motor,
        shaft=shaft,
        load=load,
        connections=[
            lp.connect(motor.flange_b, shaft.flange_a),
            lp.connect(shaft.flange_b, load.flange_a),
        ],
    )
    received = lp.modes(lp.assemble(model)).hertz
    assert received == pytest.approx([(4.0 * 2) ** 0.5 / (2 * lp.ops.pi)], rel=1e-14)


def test_with_changes_a_copy_only():
    base = Train()
    changed = base.with_({"shafts[1].c": 7.0, 'ends["left"].J': 5.0})
    names = ["shafts[1].c", 'ends["left"].J']
    assert [lp.assemble(changed).parameters[n] for n in names] == [7.0, 5.0]
    assert [lp.assemble(base).parameters[n] for n in names] == [200.0, 2.0]


def test_a_subclass_overrides_parts_and_fields():
    class Heavier(Train):
        """Train with a heavier source: J = 9."""

        source = Inertia(J=9.0)
        n = 5

    assert Heavier().n == 5
    assert lp.assemble(Heavier()).parameters["source.J"] == 9.0


def slip(**body):
    return type("Slip", (lp.Component,), body)


@pytest.mark.parametrize(
    ("make", "kind", "hint"),
    [
        (lambda: Inertia(J="heavy"), UnitError, r"J=.*kg\.m2"),
        (lambda: Train(source=3.0), DeclarationError, "component"),
        (lambda: lp.compose(a=3), DeclarationError, "compose"),
        (lambda: slip(__annotations__={"J": lp.Param}), DeclarationError, "but has no value"),
        (lambda: slip(connections=Inertia(J=1.0)), DeclarationError, "choose another"),
    ],
)
def test_wrong_use_is_refused_with_a_hint(make, kind, hint):
    with pytest.raises(kind, match=hint):
        make()
