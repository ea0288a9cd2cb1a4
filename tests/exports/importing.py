"""FMUs that several tests share: which ones are written, and an importer for both versions."""

import importlib.util
import zipfile
from xml.etree import ElementTree

import numpy as np
import pytest
from tests.exports.native import COMPILER, example_with

import bristle as br

needs_fmpy = pytest.mark.skipif(importlib.util.find_spec("fmpy") is None, reason="needs fmpy")
needs_compiler = pytest.mark.skipif(COMPILER is None, reason="needs a C compiler")
STEP = 1e-3
PLANT = br.plants.inertia(M=2.0)
WRITTEN = {
    "preisach_lugre_2": ("asymmetry", "load"),
    "preisach_lugre_3": ("asymmetry",),
    "gms_2": ("asymmetry",),
    "lugre_2": (),
    "coulomb_3": (),
}
"""What is written: a model, behind it the version of FMI, and its slots."""


def example(written):
    """Return the model of an FMU that is written."""
    return example_with(written[:-2], WRITTEN[written])


def described_by(path):
    """Return the description of an FMU."""
    with zipfile.ZipFile(path) as archive:
        return ElementTree.fromstring(archive.read("modelDescription.xml"))


class Importer:
    """An FMU in FMPy, one version like the other, to be stepped or to be integrated."""

    def __init__(self, path, folder, exchanged=False):
        import fmpy
        from fmpy.fmi2 import FMU2Model, FMU2Slave
        from fmpy.fmi3 import FMU3Model, FMU3Slave

        self.described = fmpy.read_model_description(str(path))
        self.fmi = int(self.described.fmiVersion[0])
        self.places = {
            variable.name: variable.valueReference for variable in self.described.modelVariables
        }
        fmpy.extract(str(path), str(folder))
        identifier = self.described.coSimulation.modelIdentifier
        kinds = {
            (2, False): FMU2Slave,
            (2, True): FMU2Model,
            (3, False): FMU3Slave,
            (3, True): FMU3Model,
        }
        self.unit = kinds[self.fmi, exchanged](
            guid=self.described.guid or self.described.instantiationToken,
            unzipDirectory=str(folder),
            modelIdentifier=identifier,
            instanceName="tested",
        )

    def start(self, time=0.0, **values):
        self.unit.instantiate()
        self.set(**values)
        if self.fmi == 2:
            self.unit.setupExperiment(startTime=time)
            self.unit.enterInitializationMode()
        else:
            self.unit.enterInitializationMode(startTime=time)
        self.unit.exitInitializationMode()
        return self

    def set(self, **values):
        if values:
            setter = self.unit.setReal if self.fmi == 2 else self.unit.setFloat64
            setter([self.places[name] for name in values], list(values.values()))

    def get(self, *names):
        getter = self.unit.getReal if self.fmi == 2 else self.unit.getFloat64
        return list(getter([self.places[name] for name in names]))

    def step(self, time, length, **values):
        self.set(**values)
        self.unit.doStep(currentCommunicationPoint=time, communicationStepSize=length)

    def along(self, step, inputs, *outputs, before=(), first=0, start=0.0):
        """Return outputs after each step, shape (sample, output), behind those that are asked for before it."""
        rows = []
        for k, values in enumerate(inputs, first):
            held = self.get(*before) if before else []
            self.step(start + k * step, step, **values)
            rows.append([*held, *self.get(*outputs)])
        return np.array(rows)

    def close(self):
        self.unit.terminate()
        self.unit.freeInstance()

    def saved(self):
        """Return the bytes of the state."""
        take, give, release = self._of_state("get", "serialize", "free")
        state = take()
        content = bytes(give(state))
        release(state)
        return content

    def restore(self, content):
        """Set the state from bytes."""
        read, give, release = self._of_state("deserialize", "set", "free")
        state = read(content)
        try:
            give(state)
        finally:
            release(state)

    def _of_state(self, *words):
        names = {"deserialize": "deSerialize"} if self.fmi == 2 else {}
        ending = "FMUstate" if self.fmi == 2 else "FMUState"
        return [getattr(self.unit, names.get(word, word) + ending) for word in words]
