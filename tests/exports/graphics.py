"""Exports in CUDA C++: compiled by NVRTC, which needs no graphics processor, and run on one where there is one."""

import ctypes

import numpy as np
import pytest

FLAGS = ("--fmad=false", "--std=c++17")


def ptx_of(text, *flags, architecture="compute_80"):
    """Return what NVRTC makes of a text, for the virtual machine of a family of processors."""
    nvrtc = pytest.importorskip("cuda.bindings.nvrtc", reason="needs NVRTC: pip install bristle[gpu]")
    try:
        _, program = nvrtc.nvrtcCreateProgram(text.encode(), b"axis.cu", 0, [], [])
    except RuntimeError as error:
        pytest.skip(f"needs the library of NVRTC: {error}")
    options = [f"--gpu-architecture={architecture}".encode(), *(flag.encode() for flag in flags or FLAGS)]
    (status,) = nvrtc.nvrtcCompileProgram(program, len(options), options)
    log = _room(nvrtc.nvrtcGetProgramLogSize(program)[1])
    nvrtc.nvrtcGetProgramLog(program, log)
    assert int(status) == 0, log.decode()[:4000]
    assert log.strip(b"\0") == b""
    ptx = _room(nvrtc.nvrtcGetPTXSize(program)[1])
    nvrtc.nvrtcGetPTX(program, ptx)
    return ptx.rstrip(b"\0").decode()


def _room(size):
    """Return bytes to be written over: never one alone, as CPython keeps a single object for each of these."""
    return b"\0" * (size + 2)


class Device:
    """A graphics processor with the kernels of a text."""

    def __init__(self, text):
        driver = pytest.importorskip("cuda.bindings.driver")
        self._driver = driver
        try:
            self._of(driver.cuInit(0))
            device = self._of(driver.cuDeviceGet(0))
        except Exception as error:  # noqa: BLE001  (no driver, no device: each library says it in its own way)
            pytest.skip(f"needs a graphics processor: {error}")
        major, minor = [
            self._of(driver.cuDeviceGetAttribute(attribute, device))
            for attribute in (
                driver.CUdevice_attribute.CU_DEVICE_ATTRIBUTE_COMPUTE_CAPABILITY_MAJOR,
                driver.CUdevice_attribute.CU_DEVICE_ATTRIBUTE_COMPUTE_CAPABILITY_MINOR,
            )
        ]
        self._of(driver.cuCtxSetCurrent(self._of(driver.cuDevicePrimaryCtxRetain(device))))
        ptx = ptx_of(text, architecture=f"compute_{major}{minor}")
        self._module = self._of(driver.cuModuleLoadData(ptx.encode()))

    def _of(self, answer):
        status, *values = answer
        assert int(status) == 0, status
        return values[0] if values else None

    def memory(self, content):
        """Return the address of a copy of an array, or of so many bytes, on the device."""
        size = content if isinstance(content, int) else content.nbytes
        address = self._of(self._driver.cuMemAlloc(size))
        if not isinstance(content, int):
            self._of(self._driver.cuMemcpyHtoD(address, content.ctypes.data, size))
        return address

    def launch(self, kernel, lanes, *arguments):
        """Run a kernel in so many lanes."""
        function = self._of(self._driver.cuModuleGetFunction(self._module, kernel.encode()))
        kinds = tuple({int: ctypes.c_int, float: ctypes.c_double}.get(type(a), ctypes.c_void_p) for a in arguments)
        values = tuple(a if isinstance(a, (int, float)) else int(a) for a in arguments)
        blocks = (lanes + 127) // 128
        self._of(self._driver.cuLaunchKernel(function, blocks, 1, 1, 128, 1, 1, 0, 0, (values, kinds), 0))
        self._of(self._driver.cuCtxSynchronize())

    def array(self, address, shape):
        """Return the numbers at an address."""
        content = np.empty(shape)
        self._of(self._driver.cuMemcpyDtoH(content.ctypes.data, address, content.nbytes))
        return content
