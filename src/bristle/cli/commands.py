"""The commands, each in a module; that of an app is a module of the app, found by this table alone."""

# In the order of the help.
COMMANDS = {
    "demo": "bristle.cli.demo",
    "excite": "bristle.cli.excite",
    "identify": "bristle.cli.identify",
    "predict": "bristle.cli.predict",
    "run": "bristle.cli.run",
    "study": "bristle.cli.study",
    "compare": "bristle.cli.compare",
    "tune": "bristle.cli.tune",
    "design": "bristle.cli.design",
    "lab": "bristle.cli.lab",
    "export": "bristle.cli.export",
    "paper": "bristle.cli.paper",
    "check": "bristle.cli.check",
    "models": "bristle.cli.models",
    "log": "bristle.cli.log",
    "explain": "bristle.cli.explain",
}
# Words of a command that an app carries out.
SPELLINGS = {"identify --each": "bristle.cli.fleet:identify_each", "predict ARM": "bristle.cli.arm:predict_arm"}
