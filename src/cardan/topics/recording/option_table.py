"""Every option of `cardan life`, declared once.

The command's option, the key of a campaign's file, the row of the method statement and what the
workbench sends are made from the declaration: an option is added here, and nowhere else but in
the code that uses its value and in the translations.
"""

from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import MISSING, dataclass, field, fields, replace
from typing import TYPE_CHECKING, Any, Literal, TypeVar

if TYPE_CHECKING:
    from cardan.model.application import Application

T = TypeVar("T")

SN_CURVE_MAXIMA = 10_000.0, 1e12, 100.0
"""Largest amplitude (MPa), cycles and slope of an S-N line: beyond, numbers changed places."""


@dataclass(frozen=True, kw_only=True)
class NumberRange:
    """Where a number lies: above or at least a lower bound, at most an upper one."""

    above: float | None = None
    least: float | None = None
    most: float

    @property
    def lower_bound(self) -> tuple[str, float]:
        """Lower bound, and the words that say whether it is within."""
        return ("above", self.above) if self.above is not None else ("at least", self.least or 0.0)

    def holds(self, value: float) -> bool:
        """Return whether a number lies there."""
        word, low = self.lower_bound
        return (low < value if word == "above" else low <= value) and value <= self.most


@dataclass(frozen=True, kw_only=True)
class FileKey:
    """Key of a campaign's file that holds an option.

    Attributes
    ----------
    description
        What the schema says of it.
    table
        Table that it stands in: of the campaign, of one recording, or of the strength.
    name
        The key; the option's name unless given.
    form
        `value` as the option has it, `numbers` a list of them, `axes` three numbers by gauge,
        `one or several` a text or a list of them, `by hand` where the table declares it itself.
    bounds
        Of its number or numbers; the option's unless given.
    number_format
        How a list of numbers is written as the option.
    after
        Key behind which it stands, if not in the order of declaration.
    """

    description: str = ""
    table: Literal["campaign", "recording", "strength"] = "campaign"
    name: str = ""
    form: Literal["value", "numbers", "axes", "one or several", "by hand"] = "value"
    bounds: NumberRange | None = None
    number_format: str = "{!r}"
    after: str = ""


@dataclass(frozen=True, kw_only=True)
class StatementRow:
    """Row of the method statement.

    Attributes
    ----------
    label
        Name of what is reported, to be translated.
    unit
        Printed behind a number.
    texts
        Words for the values, to be translated.
    shown
        `always`, `if not default`, or `with required option` where the option that it
        needs is given.
    after
        Option whose row it follows, if not in the order of declaration.
    """

    label: str
    unit: str = ""
    texts: Mapping[str, str] | None = None
    shown: Literal["always", "if not default", "with required option"] = "if not default"
    after: str = ""


@dataclass(frozen=True, kw_only=True)
class WorkbenchField:
    """What the workbench sends of an option, and what it calls it.

    Attributes
    ----------
    entry
        Its name in the page's message; the option's unless given.
    entry_label
        Label of a typed number, to be translated; "" where the page sends the value itself.
    overview_label
        What a campaign's overview calls it, to be translated; "" where that does not show it.
    after
        Option behind which it is listed, if not in the order of declaration.
    """

    entry: str = ""
    entry_label: str = ""
    overview_label: str = ""
    after: str = ""


@dataclass(frozen=True, kw_only=True)
class LifeOption:
    """One option: how it is written, what it may be, and where it is reported.

    Attributes
    ----------
    name, value_type, default
        Of the field of `OptionTable`, which fills them in.
    flag
        As on the command line; `--` and the name with hyphens unless given.
    metavar, help
        Of the command's help.
    help_after
        Option behind which the help has it, if not in the order of declaration.
    choices
        Values that it may have, if few.
    bounds
        Of its number.
    needs
        Option without which it does nothing.
    is_application
        Whether the command names a file whose application is the value.
    keys
        In a campaign's file.
    row
        In the method statement.
    workbench
        What the workbench sends.
    """

    name: str = ""
    value_type: Any = str
    default: Any = None
    flag: str = ""
    metavar: str | None = None
    help: str | None = None
    help_after: str = ""
    choices: tuple[str, ...] = ()
    bounds: NumberRange | None = None
    needs: str = ""
    is_application: bool = False
    keys: tuple[FileKey, ...] = ()
    row: StatementRow | None = None
    workbench: WorkbenchField | None = None

    @property
    def is_repeatable(self) -> bool:
        """Whether it may be given several times."""
        return self.value_type == tuple[str, ...]

    @property
    def number_type(self) -> type[int] | type[float] | None:
        """Type of its number; None if it is none."""
        return {int: int, float: float, float | None: float}.get(self.value_type)


def option(default: Any = MISSING, **declared: Any) -> Any:
    """Return a field of `OptionTable` with what is declared of it (`LifeOption`)."""
    return field(default=default, metadata={"option": LifeOption(**declared)})


POSITIVE = NumberRange(above=0, most=1e12)
"""Of numbers whose unit a campaign's key leaves open upwards."""
SHARE = NumberRange(least=0, most=1)

MEAN_STRESS_TEXTS = {
    "none": "not counted",
    "goodman": "by Goodman",
    "gerber": "by Gerber",
    "swt": "by Smith, Watson and Topper",
    "walker": "by Walker",
    "fkm": "by the FKM guideline",
    "morrow": "by Morrow",
}
"""What corrects the mean stress, of a cycle or a loop, by its name."""


@dataclass(frozen=True, kw_only=True)
class OptionTable:
    """The options of `cardan life`, in the order in which `--json` has them."""

    sn: str = option(
        metavar="MPa,CYCLES,SLOPE",
        help="S-N curve at the gauge, half failed: amplitude and cycles at the knee, slope.",
        help_after="modulus_GPa",
        keys=(FileKey(name="strength", form="by hand"),),
    )
    scale: tuple[str, ...] = option(
        (),
        metavar="CHANNEL=FACTOR[,OFFSET]:UNIT",
        help="Of a channel in V or mV/V: its value times FACTOR plus OFFSET is in UNIT.",
        help_after="low_pass_Hz",
    )
    gauges: tuple[str, ...] = option(
        (),
        flag="--gauge",
        metavar="CHANNEL[:UNIT]",
        help="A channel of stress or strain; may be repeated. Strain is multiplied by Young's "
        "modulus.",
        keys=(FileKey(description="CHANNEL[:UNIT] of each"),),
        workbench=WorkbenchField(),
    )
    rosettes: tuple[str, ...] = option(
        (),
        flag="--rosette",
        metavar="NAME=A,B,C[:UNIT]",
        help="Three channels of one rosette.",
        keys=(FileKey(description="NAME=A,B,C[:UNIT] of each"),),
    )
    rosette_kind: str = option(
        "rectangular",
        choices=("rectangular", "delta"),
        needs="rosettes",
        keys=(FileKey(description="its grids"),),
    )
    rosette_measure: str = option(
        "mises",
        choices=("mises", "principal", "planes"),
        help="The stress of a rosette that is counted; planes: on 20 planes, a gauge each.",
        needs="rosettes",
        keys=(FileKey(description="the stress of a rosette that is counted"),),
    )
    modulus_GPa: float = option(  # noqa: N815
        206.0,
        bounds=NumberRange(above=0, most=2000),
        keys=(FileKey(description="Young's modulus", bounds=POSITIVE),),
        row=StatementRow(
            label="Young's modulus", unit=" GPa", shown="always", after="mean_sensitivity"
        ),
        workbench=WorkbenchField(entry="modulus", entry_label="Young's modulus [GPa]"),
    )
    scatter: float = option(
        0.0,
        help="Standard deviation of log10 strength.",
        bounds=SHARE,
        keys=(FileKey(description="standard deviation of log10 strength", table="strength"),),
        row=StatementRow(label="scatter of log10 strength", after="modulus_GPa"),
    )
    gauge_error: float = option(
        0.0,
        help="Relative standard deviation of the stress scale.",
        bounds=SHARE,
        keys=(FileKey(description="relative standard deviation of the stress scale"),),
        row=StatementRow(label="error of the gauge", after="scatter"),
    )
    miner: str = option(
        "modified",
        choices=("original", "elementary", "modified"),
        keys=(FileKey(description="what is below the knee", table="strength"),),
    )
    mean_stress: str = option(
        "none",
        choices=("none", "goodman", "gerber", "swt", "walker", "fkm"),
        keys=(FileKey(description="correction for mean stress"),),
        row=StatementRow(label="mean stress", texts=MEAN_STRESS_TEXTS, shown="always"),
    )
    ultimate_MPa: float | None = option(  # noqa: N815
        None,
        bounds=NumberRange(above=0, most=10_000),
        keys=(FileKey(description="tensile strength", bounds=POSITIVE),),
        row=StatementRow(label="tensile strength", unit=" MPa", after="low_pass_Hz"),
    )
    mean_sensitivity: float | None = option(
        None,
        help="M of fkm, or the exponent of walker (0.65).",
        bounds=SHARE,
        keys=(FileKey(description="M of fkm, exponent of walker"),),
        row=StatementRow(label="mean-stress sensitivity", after="ultimate_MPa"),
    )
    residue: str = option(
        "half",
        choices=("half", "repeat", "discard"),
        help="What the open residue counts for.",
        keys=(FileKey(description="what the open residue counts for"),),
        row=StatementRow(
            label="residue",
            texts={"half": "half cycles", "repeat": "repeating", "discard": "discarded"},
            shown="always",
        ),
    )
    allowed: float = option(
        1.0,
        help="Damage at failure.",
        bounds=NumberRange(above=0, most=100),
        keys=(FileKey(description="damage at failure", bounds=POSITIVE),),
        row=StatementRow(label="failure at damage", shown="always"),
    )
    zero: str = option(
        "none",
        choices=("none", "start", "median", "drift"),
        help="What is taken off each channel as zero.",
        keys=(FileKey(description="what is taken off each channel as zero"),),
        row=StatementRow(
            label="taken off as zero",
            texts={
                "none": "nothing, as recorded",
                "start": "the level at the start",
                "median": "the median",
                "drift": "the running median",
            },
            shown="always",
        ),
        workbench=WorkbenchField(),
    )
    low_pass_Hz: float | None = option(  # noqa: N815
        None,
        help="Count nothing faster.",
        bounds=NumberRange(above=0, most=1e9),
        keys=(FileKey(description="count nothing faster", bounds=POSITIVE),),
        row=StatementRow(label="nothing faster than", unit=" Hz"),
    )
    speed: str | None = option(
        None,
        metavar="CHANNEL[:UNIT]",
        help="Shaft speed: with it, causes are found. In km/h with --axle-ratio and "
        "--tyre-radius-m.",
        keys=(FileKey(description="CHANNEL[:UNIT] of the shaft's speed"),),
        workbench=WorkbenchField(overview_label="shaft speed"),
    )
    tacho: str | None = option(
        None,
        metavar="CHANNEL",
        help="Shaft tacho, in place of a speed.",
        keys=(FileKey(description="CHANNEL of the shaft's tacho"),),
        workbench=WorkbenchField(overview_label="tacho"),
    )
    pulses: int = option(
        1,
        help="Of the tacho, per turn.",
        bounds=NumberRange(least=1, most=10_000),
        needs="tacho",
        keys=(FileKey(description="of it, a turn"),),
    )
    estimate_speed: str | None = option(
        None,
        metavar="GAUGE",
        help="No speed: find it in this channel. It gives no angle to trust.",
    )
    joint_orders: str = option(
        "2,4",
        help="Joint orders to compare with those of other sources (of 2, 4, 6); the joints' own "
        "part is sought at all three.",
    )
    engine: str | None = option(
        None,
        metavar="CHANNEL[:UNIT]",
        help="Engine speed.",
        keys=(FileKey(description="CHANNEL[:UNIT] of the engine's speed"),),
        workbench=WorkbenchField(overview_label="engine speed", after="torque"),
    )
    engine_orders: str = option(
        "",
        help="Half its cylinders, and twice that; 3,6 assumed, and then in direct gear order 2 may "
        "always be the engine's.",
        keys=(
            FileKey(
                description="orders it excites: half its cylinders, and twice that; 3 and 6 "
                "assumed",
                form="numbers",
                bounds=NumberRange(above=0, most=100),
                number_format="{:g}",
            ),
        ),
    )
    axle_ratio: float | None = option(
        None,
        help="Shaft turns per wheel turn: wheel orders.",
        bounds=NumberRange(above=0, most=100),
        keys=(FileKey(description="shaft turns a wheel turn", after="torque"),),
    )
    tyre_radius_m: float | None = option(
        None,
        help="With the axle ratio: kilometres.",
        bounds=NumberRange(above=0, most=5),
        keys=(FileKey(description="static radius of the tyre", after="axle_ratio"),),
    )
    torque: str | None = option(
        None,
        metavar="CHANNEL[:UNIT]",
        help="Shaft torque.",
        keys=(FileKey(description="CHANNEL[:UNIT] of the shaft's torque"),),
        workbench=WorkbenchField(overview_label="shaft torque"),
    )
    predicted: tuple[str, ...] = option(
        (),
        metavar="GAUGE=MPa_per_kNm",
        help="Order-2 stress the geometry predicts, to hold against the measured.",
    )
    application: "Application | None" = option(  # noqa: RUF009
        None,
        help="Application file that predicts it instead, with --unit-stress.",
        is_application=True,
        keys=(FileKey(description="an application file beside this one, whose line is under way"),),
    )
    unit_stress: tuple[str, ...] = option(
        (),
        metavar="GAUGE=X,Y,Z",
        help="MPa at the gauge for 1 kN of the bearing along each vehicle axis.",
        keys=(
            FileKey(
                description="[x, y, z] at each gauge for 1 kN of the bearing along each axis",
                name="unit_stress_MPa_kN",
                form="axes",
                bounds=NumberRange(least=-1e6, most=1e6),
                after="bearing",
            ),
        ),
    )
    state: str = option(
        "gvw",
        help="State of the application.",
        needs="application",
        keys=(FileKey(description="of it, whose geometry counts"),),
    )
    bearing: int = option(
        1,
        help="Centre bearing number.",
        bounds=NumberRange(least=1, most=100),
        needs="application",
        keys=(FileKey(description="its centre bearing that the gauges feel"),),
    )
    strain_life: str | None = option(
        None,
        metavar="MPa,B,STRAIN,C[,MPa,N]",
        help="Life until a crack by the local strain, with memory: σf', b, εf', c; K' and n' "
        "follow unless given.",
        keys=(
            FileKey(
                description="σf' MPa, b, εf', c, perhaps K' MPa and n': life by the local strain",
                form="numbers",
                bounds=NumberRange(least=-1e6, most=1e6),
                after="changed",
            ),
        ),
        row=StatementRow(label="strain-life curve"),
    )
    notch: float | None = option(
        None,
        help="K_t from the gauge to a notch, by Neuber; without it the gauge felt the strain "
        "itself.",
        bounds=NumberRange(least=1, most=20),
        needs="strain_life",
        keys=(FileKey(description="K_t from the gauges to the notch", after="strain_life"),),
        row=StatementRow(label="K_t of the notch"),
    )
    strain_mean: str = option(
        "swt",
        choices=("swt", "morrow", "none"),
        help="What the mean stress of a loop does.",
        needs="strain_life",
        keys=(FileKey(description="what the mean stress of a loop does", after="notch"),),
        row=StatementRow(
            label="mean stress of a loop", texts=MEAN_STRESS_TEXTS, shown="with required option"
        ),
    )
    crack: str | None = option(
        None,
        metavar="MM,MM,C,M",
        help="Growth of a crack from one length to another: C ΔK^M, m a cycle, ΔK in MPa√m.",
        keys=(
            FileKey(
                description="from mm, to mm, C in m a cycle and MPa√m, m: growth of a crack",
                form="numbers",
                bounds=NumberRange(least=0, most=1e4),
                after="strain_mean",
            ),
        ),
        row=StatementRow(label="crack from, to in mm, C, m"),
    )
    crack_threshold: float = option(
        0.0,
        help="ΔK that grows it, MPa√m.",
        bounds=NumberRange(least=0, most=100),
        needs="crack",
        keys=(FileKey(description="ΔK that grows it, MPa√m", after="crack"),),
        row=StatementRow(label="its threshold", unit=" MPa√m"),
    )
    crack_shape: float = option(
        1.12,
        help="Y of K = Y S √(πa).",
        bounds=NumberRange(above=0, most=10),
        needs="crack",
        keys=(FileKey(description="Y of K = Y S √(πa)", after="crack_threshold"),),
        row=StatementRow(label="its Y", shown="with required option"),
    )
    service_hours: float | None = option(
        None,
        help="Probability of failure within so many hours (FORM, SORM, sampled), by the scatter "
        "of strength, of the damage at failure and of the gauge.",
        bounds=POSITIVE,
        keys=(FileKey(description="hours the odds of failure are of", after="crack_shape"),),
    )
    miner_scatter: float = option(
        0.3,
        help="Coefficient of variation of the damage at failure.",
        bounds=NumberRange(least=0, most=2),
        needs="service_hours",
        keys=(
            FileKey(
                description="coefficient of variation of the damage at failure",
                after="service_hours",
            ),
        ),
    )
    usage: bool = option(
        default=False,
        help="Report when and where the damage came: by gear, speed and torque, the largest "
        "stresses, the long run with its interval, and how short a test can be.",
        keys=(
            FileKey(
                description="whether it is told when and where the damage came",
                after="miner_scatter",
            ),
        ),
    )
    identify: bool = option(
        default=False,
        help="Hold the recorded orders against the application's line on rubber, and look for its "
        "stiffness, loss, yoke phase, unbalance and the bracket's mode.",
        keys=(FileKey(description="whether the application's numbers are looked for"),),
    )
    changed: "Application | None" = option(  # noqa: RUF009
        None,
        help="With --identify: another application, driven as the recording was: its damage "
        "and life are predicted.",
        is_application=True,
        keys=(
            FileKey(
                description="another application file beside this one, driven as the recordings "
                "were"
            ),
        ),
    )
    rate: float | None = option(
        None,
        help="Samples a second, above what the file says.",
        bounds=NumberRange(above=0, most=1e9),
        keys=(
            FileKey(
                description="samples a second, above what the file says",
                table="recording",
                name="rate_Hz",
                after="segments",
            ),
        ),
    )
    time: str | None = option(
        None,
        metavar="NAME[:UNIT]",
        help="Time column, its unit if the file has none.",
        keys=(FileKey(description="name of the time column", table="recording", after="rate_Hz"),),
    )
    group: str = option(
        "",
        help="Group of an HDF5, TDMS or MDF4 file.",
        keys=(FileKey(description="HDF5, TDMS or MDF4 group", table="recording", after="time"),),
    )
    dbc: tuple[str, ...] = option(
        (),
        metavar="FILE",
        help="CAN database of a log of frames (MDF4, BLF, ASC): its signals are the channels, by "
        "their names there or in J1939 (EngineSpeed, SPN190); may be repeated.",
        keys=(
            FileKey(
                description="CAN database (DBC) of a log of frames, or a list of them, next to "
                "this file",
                form="one or several",
                table="recording",
                after="group",
            ),
        ),
    )
    mask: tuple[str, ...] = option(
        (),
        metavar="[CHANNEL=]KIND[@FROM..TO]",
        help="Make a hole of what looks wrong (sentinel, spike, dropout, freeze, "
        "response, noise, repeat), "
        "or of a time in seconds, FROM..TO; take a zero-step, a change of gain or hum off; may be "
        "repeated. Nothing is masked by itself.",
        keys=(
            FileKey(description="what is a hole in every recording: [CHANNEL=]KIND[@FROM..TO]"),
            FileKey(
                description="what of it is a hole: [CHANNEL=]KIND[@FROM..TO] or FROM..TO",
                table="recording",
                after="channels",
            ),
        ),
        workbench=WorkbenchField(),
    )
    accept: tuple[str, ...] = option(
        (),
        metavar="[CHANNEL=]KIND[@FROM..TO]",
        help="Confirm what looks wrong as felt by the part (also clip, drift, hum) or as stated "
        "(unit, rate, strength); may be repeated.",
        keys=(
            FileKey(description="what the part felt"),
            FileKey(description="what of it the part felt", table="recording", after="mask"),
        ),
        workbench=WorkbenchField(),
    )
    between_samples: str = option(
        "auto",
        choices=("auto", "yes", "no"),
        help="Look for crests between samples; auto: where they lose 1 % or more.",
        keys=(
            FileKey(
                description="whether crests are looked for between samples", after="low_pass_Hz"
            ),
        ),
        row=StatementRow(
            label="crests between samples",
            texts={
                "auto": "where 1 % and more is lost there",
                "yes": "looked for",
                "no": "not looked for",
            },
            shown="always",
            after="zero",
        ),
    )
    limits: str | None = option(
        None,
        metavar="PROFILE",
        help="Limit profile: its fatigue_life and fatigue_damage are held against every gauge.",
        help_after="target_hours",
        keys=(FileKey(description="a profile, by name or as a file"),),
    )
    target_hours: float | None = option(
        None,
        help="Fail where a gauge lives shorter.",
        bounds=POSITIVE,
        keys=(FileKey(description="what every gauge has to live of the mix"),),
        workbench=WorkbenchField(entry="hours", entry_label="hours to live"),
    )


OPTIONS: Mapping[str, LifeOption] = {
    f.name: replace(
        f.metadata["option"],
        name=f.name,
        value_type=f.type,
        default=None if f.default is MISSING else f.default,
        flag=f.metadata["option"].flag or f"--{f.name.replace('_', '-')}",
    )
    for f in fields(OptionTable)
}
"""The options by name."""


def in_order(
    items: Iterable[T], *, name: Callable[[T], str], after: Callable[[T], str]
) -> tuple[T, ...]:
    """Return items as declared, but each with an `after` behind the item of that name."""
    leading: list[T] = []
    following: dict[str, list[T]] = {}
    for item in items:
        (following.setdefault(after(item), []) if after(item) else leading).append(item)

    def with_followers(some: Iterable[T]) -> Iterator[T]:
        for item in some:
            yield item
            yield from with_followers(following.get(name(item), ()))

    return tuple(with_followers(leading))


def options_in_help_order() -> tuple[LifeOption, ...]:
    """Return the options as the command's help lists them."""
    return in_order(OPTIONS.values(), name=lambda o: o.name, after=lambda o: o.help_after)


def file_keys(table: str) -> Iterator[tuple[str, LifeOption, FileKey]]:
    """Yield the keys of a table of a campaign's file as declared: name, option and key."""
    for o in OPTIONS.values():
        for key in o.keys:
            if key.table == table and key.form != "by hand":
                yield key.name or o.name, o, key


def statement_rows() -> tuple[tuple[LifeOption, StatementRow], ...]:
    """Return the rows of the method statement that show an option's value."""
    rows = ((o, o.row) for o in OPTIONS.values() if o.row is not None)
    return in_order(rows, name=lambda r: r[0].name, after=lambda r: r[1].after)


def workbench_fields() -> dict[str, WorkbenchField]:
    """Return what the workbench sends, by option."""
    sent = ((o.name, o.workbench) for o in OPTIONS.values() if o.workbench is not None)
    return dict(in_order(sent, name=lambda f: f[0], after=lambda f: f[1].after))
