"""What earlier releases offered and this one does not: each name is refused with its successor."""

# Former names that share a successor, separated by commas -> what to do now. A command stands before its option, and "explain" before
# the code of a warning. A name of Python is written in full, and * stands for each unknown name of a package.
SUCCESSORS = {
    "bristle watch, bristle.apps.study.fleet.watch": "Use bristle identify LOGS --each. Its report shows which axis differs",
    "bristle bench, bristle.bench": "Run python -m benchmarks board at the root of the source tree",
    "--data": "Write --format csv",
    "--size-limit": 'Set BRISTLE_SIZE_LIMIT="2 GB" in the environment',
    "--global, --no-global, identification.global_search": "Leave it out: the search starts from the result of inverse dynamics",
    "--set, --decimation": "Write decimation = 5 under [identification] of the axis file, NAME = VALUE under [identification.settings]",
    "--truth, paper --axis": "Give frictions or model files after --robust: bristle paper --robust gms results/model.toml",
    "--window": "Call br.compare(..., window=...) in Python",
    "lab --log, lab --axis": "Identify the log: the report of bristle identify animates it",
    "demo --format": "Write bristle identify DIR/log.csv --axis DIR/axis.toml --out OTHER --format svg",
    "--dry-run": "Start the command: a terminal shows the remaining time, and an interrupted run continues from its finished parts",
    "export --draws": "The results of identify contain draws.parquet, or draws.npz without pyarrow: one row per draw, in SI units",
    "check --allow-code, excite --allow-code": "Run bristle check OWN.py first: it allows the code in OWN.py",
    "injected.unit": 'Write the unit in the gain, such as gain = "2 V"',
    "keep.traces": "Delete this key: bristle study FILE --run N writes the signals of a run",
    "settings.*": "Remove a threshold of an earlier release. missing_evidence replaces missing_share and those like it",
    "explain begins_at_rest, explain run_in": "Run bristle explain start_of_contact",
    "explain clock_suspect": "Run bristle explain unit_suspect",
    "explain creeps, explain rests_left_out": "Run bristle explain rests",
    "explain filtered_rows, explain slow_sampling": "Run bristle explain filtered",
    "explain intervals_loop": "Run bristle explain intervals",
    "explain logs_repeat, explain repeats_one_motion": "Run bristle explain motion_repeats",
    "explain like_a_spring, explain missing_channel, explain missing_position, explain missing_ripple, explain missing_gravity, "
    "explain missing_transmitted, explain missing_load, explain missing_temperature": "Run bristle explain terms_beside",
    "explain no_bend": "Run bristle explain few_strokes",
    "explain no_interval": "Run bristle explain few_cycles",
    "explain no_steady_slide": "Run bristle explain no_fall",
    "explain rates_differ, explain stamps_jitter": "Run bristle explain resampled",
    "explain seen_together, explain unseen": "Run bristle explain small_effect",
    "bristle.load_model_file, bristle.files.load_model_file": "Call bristle.load_code",
    "bristle.workflow": "Call identify, compare, load and prepare of bristle",
    "bristle.stability, bristle.loop_design": "Its names are in bristle.apps.design",
    "bristle.hysteresis_identification": "Its names are in bristle.identification.hysteresis",
    "bristle.simulation.certificates.*": "Call traced(model, Path.to_force, levels) or traced(model, Path.to_position, turns)",
    "bristle.engine.force_in_turns": "Call bristle.engine.force_along for each trajectory",
    "bristle.report.figures.*": "A figure of one report is in its module, such as bristle.report.figures.fit",
    "bristle.apps.study.fleet.*, bristle.apps.study.*": "Look in its modules fleet.plan and run",
    "bristle.identification.*": "Parts of a result are in bristle.identification.result",
    "bristle.logs.sign_of_effort": "Run bristle log",
    "bristle.apps.targets.AxisEnv, bristle.apps.targets.gymnasium": "Copy the environment from examples/gymnasium_environment.py",
    "bristle.apps.targets.torch": "Copy the function from examples/torch_friction.py",
}
FORMER = {name: advice for names, advice in SUCCESSORS.items() for name in names.split(", ")}
"""Each former name, with what to do now."""


def successor(*names: str) -> str:
    """Return what replaces the first former name among `names`; empty if there is none."""
    return next((FORMER[name] for name in names if name in FORMER), "")


def refusal(package: str, name: str) -> str:
    """Return the sentences that refuse a former name of a package; empty if there was no such name."""
    advice = successor(f"{package}.{name}", f"{package}.*")
    if not advice:
        return ""
    return f"{package}.{name} does not exist. {advice}"
