"""Reference cases, scenes of the machines and random nets stand in folders of their own."""

import sys
from pathlib import Path

import pytest

for folder in ("msl", "kernel", "components"):
    sys.path.append(str(Path(__file__).parents[1] / folder))


@pytest.fixture(scope="session")
def exported(tmp_path_factory):
    """Folder of a PI controller as units."""
    from imported_drives import PI

    import lumped as lp

    folder = tmp_path_factory.mktemp("units")
    system = lp.assemble(PI(wanted=0.0, measured=0.0))
    for version in ("2.0", "3.0"):
        lp.export_fmu(
            system,
            folder / f"pi_{version}.fmu",
            version=version,
            inputs=["wanted", "measured"],
            outputs=["M"],
            rtol=1e-10,
        )
    return folder
