"""The features of conrod: each is a folder, and one entry here that says what it adds.

To add a feature, write its folder and its entry; to drop one, delete both. A folder has a function that users call
(`api.py`), a verb of the command line (`verb.py`), what is run and found, and its report with templates.
`conrod.validate` and `conrod.check_model` are required; the rest of conrod does without any of the others.
"""

# Nothing is imported here, see `conrod/__init__.py`.


class Slice:
    """A feature of conrod, with its folder, verbs, functions and reports.

    Args:
        folder: package, below `conrod`.
        verbs: help of each verb, in a line; a verb is a function of the folder's `verb.py`.
        functions: public functions, each with the module that it is in.
        reports: kinds of reports, each with its module and the name of its `Kind` there.
        uses: other slices that it is built on.
    """

    def __init__(
        self,
        folder: str,
        *,
        verbs: dict[str, str] | None = None,
        functions: dict[str, str] | None = None,
        reports: dict[str, str] | None = None,
        uses: tuple[str, ...] = (),
    ) -> None:
        self.folder = folder
        self.package = f"conrod.{folder}"
        self.verbs = verbs or {}
        self.functions = functions or {}
        self.reports = reports or {}
        self.uses = uses


REQUIRED = ("studies.validation", "models.check")

# In the order of a first look at `conrod --help`.
SLICES = (
    Slice(
        "studies.validation",
        verbs={"validate": "Compare engines with the exact motion of scenes."},
        functions={"validate": "api"},
        reports={"validation": "report.VALIDATION_REPORT"},
    ),
    Slice(
        "studies.space",
        functions={"validate_in_space": "api"},
        reports={"space": "report.SPACE_REPORT"},
    ),
    Slice("studies.detection", uses=("studies.validation", "studies.forces")),
    Slice(
        "studies.forces",
        verbs={"forces": "Compare the forces that engines report with the exact ones."},
        functions={"forces": "api"},
        reports={"forces": "report.FORCES_REPORT"},
    ),
    Slice(
        "studies.free_motion",
        verbs={"free": "Compare motion without a drive with the equations of motion."},
        functions={"free_motion": "api"},
        reports={"motion": "report.FREE_MOTION_REPORT"},
    ),
    Slice(
        "models.check",
        verbs={"check": "Judge your own model, FMU or table by an exact motion."},
        functions={"check": "dispatch", "check_model": "api"},
        reports={"model": "report.MODEL_REPORT"},
        uses=("studies.validation",),
    ),
    Slice(
        "models.tables",
        functions={"check_table": "api"},
        reports={"trajectory": "report.TABLE_REPORT"},
        uses=("models.check",),
    ),
    Slice(
        "models.torque_runs",
        functions={"check_torque_run": "api"},
        reports={"torque-run": "report.TORQUE_RUN_REPORT"},
        uses=("models.tables",),
    ),
    Slice("models.fmu", functions={"check_fmu": "api"}, uses=("models.tables",)),
    Slice("models.loops", functions={"check_loops": "api"}, reports={"loops": "report.LOOPS_REPORT"}),
    Slice(
        "models.engine_comparison",
        functions={"check_loops_in_engines": "api"},
        uses=("models.loops", "studies.space"),
    ),
    Slice(
        "models.inspection",
        functions={"inspect_model": "api"},
        reports={"inspection": "report.INSPECTION_REPORT"},
        uses=("models.loops", "models.lint"),
    ),
    Slice(
        "models.invariances",
        verbs={"invariances": "Change what must not matter in a model."},
        functions={"invariances": "api"},
        reports={"invariances": "report.INVARIANCES_REPORT"},
    ),
    Slice(
        "studies.sweep",
        verbs={
            "sweep": "Measure the trade of speed for accuracy over many settings.",
            "recommend": "Find the cheapest settings within tolerances, ready to paste.",
        },
        functions={"sweep": "api", "recommend": "api"},
        reports={"sweep": "report.SWEEP_REPORT", "recommendation": "recommendation_report.RECOMMENDATION_REPORT"},
    ),
    Slice(
        "studies.limits",
        verbs={"limits": "Find where each engine stops being trustworthy, and how."},
        functions={"limits": "api"},
        reports={"limits": "report.LIMITS_REPORT"},
    ),
    Slice(
        "studies.ablate",
        verbs={"ablate": "Measure what each ingredient of a model costs and changes."},
        functions={"ablate": "api"},
        reports={"ablate": "report.ABLATE_REPORT"},
    ),
    Slice(
        "studies.versions",
        verbs={"versions": "Measure what each release of an engine changed."},
        functions={"versions": "api"},
        reports={"versions": "report.VERSIONS_REPORT"},
    ),
    Slice(
        "models.upgrades",
        functions={"compare_releases": "api"},
        reports={"upgrades": "report.UPGRADES_REPORT"},
    ),
    Slice(
        "models.printed",
        verbs={"audit": "Check published figures of a textbook: a verdict for each."},
        functions={"audit": "api"},
        reports={"printed-values": "report.PRINTED_VALUES_REPORT"},
    ),
    Slice(
        "models.lint",
        verbs={"lint": "Find what a MuJoCo model has in excess, and what makes it fail."},
        functions={"lint": "api"},
    ),
    Slice(
        "models.harden",
        verbs={"harden": "Make the closed loops of a MuJoCo model stay closed."},
        functions={"harden": "api"},
    ),
    Slice(
        "models.export",
        verbs={"export": "Write a scene's model, its exact motion, or a pack for others."},
        functions={"export": "api"},
    ),
    Slice("verification"),
    Slice(
        "guide.explain",
        verbs={"explain": "Explain a word that conrod prints, and what to do about it."},
        functions={"explain": "api"},
    ),
    Slice(
        "guide.doctor",
        verbs={"doctor": "Check this installation, and that wrong runs are noticed here."},
        functions={"doctor": "api"},
        uses=("studies.validation",),
    ),
    Slice(
        "guide.init",
        verbs={"init": "Begin a project: a mechanism file, a test and a workflow."},
        functions={"begin_project": "api"},
    ),
)


def has_slice(folder: str) -> bool:
    """Return True if this conrod has the feature of a folder."""
    return any(one.folder == folder for one in SLICES)
