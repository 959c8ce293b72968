"""mitsuba with mitransient's plug-ins, the path tracer that the nominal model is compared with."""

import ctypes.util
import os
from glob import glob

import pytest


def path_tracer():
    """The module `mitsuba`; LLVM as Debian installs it (libllvm19) or as DRJIT_LIBLLVM_PATH says. Skips without."""
    known = [*sorted(glob("/usr/lib/*/libLLVM*19*.so*")), ctypes.util.find_library("LLVM-19")]
    found = os.environ.get("DRJIT_LIBLLVM_PATH") or next(filter(None, known), None)
    if found is None:
        pytest.skip("no LLVM is found, which mitransient runs on: install libllvm19 or set DRJIT_LIBLLVM_PATH")
    os.environ["DRJIT_LIBLLVM_PATH"] = found
    module = pytest.importorskip("mitsuba", reason="mitransient is not installed: pip install .[mitransient]")
    module.set_variant("llvm_ad_mono")
    pytest.importorskip("mitransient", reason="mitransient is not installed: pip install .[mitransient]")
    return module
