"""The commands, each in a module; that of an app is a module of the app, found by this table alone."""

# In the order of the help.
COMMANDS = {
    "demo": "bristle.cli.demo",
    "excite": "bristle.cli.excite",
    "identify": "bristle.cli.identify",
    "predict": "bristle.cli.predict",
    "run": "bristle.cli.run",
    "study": "bristle.apps.study.command",
    "compare": "bristle.cli.compare",
    "tune": "bristle.apps.tune.command",
    "design": "bristle.apps.design.command",
    "lab": "bristle.apps.lab.command",
    "export": "bristle.cli.export",
    "paper": "bristle.apps.paper.command",
    "check": "bristle.cli.check",
    "models": "bristle.cli.models",
    "log": "bristle.cli.log",
    "explain": "bristle.cli.explain",
}
# Words of a command that an app carries out.
SPELLINGS = {
    "identify --each": "bristle.apps.study.fleet.command:identify_each",
    "predict ARM": "bristle.apps.arm.command:predict_arm",
}
