"""The mistakes that are answered when a robot is calibrated, or its measurements planned, in the order of the guide's table."""

from guide_mistakes import Mistake
from guide_mistakes_of_files import MOTOR

LOADED = '{"Fx": [-10.0, -20.0], "dx": [-1e-6, -2e-6]}'


def call(cure: str, unknowns: str = '["left"]', rows: str = LOADED, more: str = "", written: str = "") -> Mistake:
    """Return a mistake in the arguments of ``ks.calibrate``, of which only those that are wrong are shown."""
    shown = more or (f"unknowns={unknowns}" if rows == LOADED else rows)
    code = f"ks.calibrate(robot, {rows}, {unknowns}{more and f', {more}'})"
    return Mistake(written or f"`ks.calibrate(…, {shown})`", cure, code=code)


def table(text: str, cure: str, gauges: bool = False) -> Mistake:
    """Return a mistake in a table of measurements, or of gauges."""
    rows = LOADED if gauges else 'folder / "mine.csv"'
    end = ', gauges=folder / "mine.csv"' if gauges else ""
    code = f'(folder / "mine.csv").write_text({text!r}, encoding="utf-8")\nks.calibrate(robot, {rows}, ["left"]{end})'
    lines = " / ".join(f"`{line}`" for line in text.splitlines())
    return Mistake(f"{'gauges' if gauges else 'measurements'}: {lines}", cure, code=code)


def plan(cure: str, arguments: str) -> Mistake:
    """Return a mistake in the arguments of ``ks.plan_measurements``, after robot and unknowns."""
    return Mistake(f"`ks.plan_measurements(…, {arguments})`", cure, code=f'ks.plan_measurements(robot, ["left"], {arguments})')


MEASUREMENTS = (
    Mistake("`ks.calibrate(file, …)`", "`ks.load_robot(file)`.", code=f'ks.calibrate("lift.urdf", {LOADED}, ["left"])'),
    call("Columns, rows, or the path of a CSV file.", rows="3"),
    call("As many readings as loads.", rows='{"Fx": [-10.0, -20.0, 0.0], "dx": [-1e-6, -2e-6]}'),
    call("A column of what was read.", rows='{"Fx": [-10.0, -20.0]}'),
    call("One of those.", rows='{"Fx": [-10.0, -20.0], "deflection": [-1e-6, -2e-6]}'),
    call("One of them.", rows='{"dx": [-1e-6], "dx [um]": [-1.0]}'),
    call("Rows have the same coordinates.", rows='[{"a": 0.1, "dx": 0.0}, {"dx": 0.0}]'),
    call("A number, in m.", rows='{"Fx": [-10.0], "dx": ["much"]}'),
    table("Fx,dx\n", "Rows below the titles."),
    table("Fx;dx\n-10;-1e-6\n", "Save it with commas."),
    table("Fx\tdx\n-10\t-1e-6\n", "Save it with commas."),
    table("Fx,dx\n-10,-1e-6,4\n", "A cell for each title."),
    table("Fx (N),dx (um)\n-10,-1\n", "`Fx [N]`."),
    table("x,dx\n400,-1e-6\n", "A pose in reach: `x [mm]`."),
    table("Fx [N],dx [um]\n-10,-1 N\n", "A length."),
    Mistake("a table that is not there", "Its path.", code='ks.calibrate(robot, "mine.csv", ["left"])'),
    call("Names of what is looked for.", unknowns="[]"),
    call("One of those.", unknowns='["lever"]'),
    call("Each once.", unknowns='["left", "left+right"]'),
    call("0.95.", more="level=95"),
    call("`\"undeformed\"`, `\"unloaded\"`, or the coordinates of a pose.", more='reference="zero"'),
    call("The same coordinates as in the table.", more='reference={"a": 0.1, "x": 0.2}'),
    call("One pose.", rows='{"a": [0.1], "dx": [1e-6]}', more='reference={"a": [0.1, 0.2]}'),
    call("A payload.", more="payload=2.0"),
    call("One point.", more="point=[[0, 0, 0.1], [0, 0, 0.2]]"),
    call("Three numbers.", more="gravity=[[0, 0, -9.81], [0, 0, 0]]"),
    call("On the platform; on links, `loads=`.", more='payload=ks.Payload(2.0, link="left")'),
    Mistake('`ks.calibrate(robot, …, ["platform_mass"])`, readings upwards', "Right signs; or the unknown that makes them.",
            code='rows = {"z": [0.5, 0.6], "rx": [0.0] * 2, "ry": [0.0] * 2, "dz": [1e-6, 1e-6]}\n'
            'ks.calibrate(ks.load_robot("3rps"), rows, ["platform_mass"])', ours="the search for platform_mass came to"),
    call("A sigma for each.", rows='{"dx": [-1e-6], "dry": [1e-6]}'),
    Mistake("the `<transmission>` left out", "The same as for an analysis.", ((MOTOR, ""),),
            code=f'ks.calibrate(robot, {LOADED}, ["left"])'),
    call("`ks.Gauge(…)`.", more='gauges={"tip": (0, 0, 1)}'),
    call("A direction.", more='gauges={"tip": ks.Gauge(direction=(0, 0, 0))}'),
    table("name,ux,uy,uz,colour\ntip,0,0,1,red\n", "Leave the column out.", True),
    table("name,ux,uy\ntip,0,1\n", "All three; 0 where it does not point.", True),
    table("name,ux,uy,uz\ntip,0,0,1\ntip,1,0,0\n", "Two names.", True),
    table("name,ux,uy,uz,x,y,z\ntip,0,0,1,0.1,,0\n", "All three.", True),
    plan("One of those, or `gauges=`.", '1, read=["tip"]'),
    plan("At least one.", "1, read=[]"),
    plan("Fewer, or more poses and loads.", "2"),
    Mistake("two unknowns, one reading each, and `n=1`", "More measurements.",
            code='ks.plan_measurements(robot, ["left", "offset.dx"], 1, {"a": [0.1, 0.2]}, [10, 0, 0, 0, 0, 0], read=["dx"])'),
    plan("Poses in reach.", '1, {"a": [1.5]}'),
    plan("A whole number.", '1, seed="random"'),
    plan("Forces and moments.", "1, loads=[0, 0, -10]"),
    plan("A coarser grid.", '1, {"a": np.linspace(-1, 1, 20001)}'),
)  # fmt: skip
