"""Find or install the programs to compare rtcli with, and report those that are missing.

POV-Ray, Tachyon and Embree come from the system's package manager, Mitsuba 3 goes into a virtual environment of
its own, and `embree.cpp` and the kernel of `brute_force.c` are compiled. A program that is not available is
`None`, and reported on standard error.
"""

from __future__ import annotations

import glob
import json
import os
import re
import shutil
import subprocess
import sys
from dataclasses import dataclass, field
from pathlib import Path

import scenes

HERE = Path(__file__).parent
WORK = HERE.parent / "out" / "bench"

# The LLVM libraries that Mitsuba supports, newest first; it refuses any older than 15.
LLVM_PACKAGES = ("libllvm20", "libllvm19", "libllvm18", "libllvm17", "libllvm16", "libllvm15")
LLVM_PATHS = ("/usr/lib/*/libLLVM*.so*", "/usr/lib/llvm-*/lib/libLLVM*.so*", "/usr/lib64/libLLVM*.so*")

# Give the kernel every advantage; rtcli itself is built without these flags.
C_FLAGS = ("-O3", "-march=native", "-ffast-math", "-std=gnu11")
CPP_FLAGS = ("-O3", "-march=native", "-std=c++17")

PROBE = """
import drjit, mitsuba
mitsuba.set_variant("llvm_ad_rgb")
drjit.eval(drjit.arange(mitsuba.Float, 8))
print(mitsuba.__version__, ".".join(map(str, drjit.detail.llvm_version())))
"""


@dataclass(frozen=True)
class Peer:
    """A program to compare with.

    Parameters
    ----------
    program
        The path of the executable.
    version
        The name and version, for people.
    environment
        Environment variables that it needs.
    """

    program: str
    version: str
    environment: dict[str, str] = field(default_factory=dict)


def leave_out(name: str, reason: str) -> None:
    """Report that a peer is missing, so that the results are not taken for complete."""
    sys.stderr.write(f"\n*** {name} IS LEFT OUT: {reason}\n\n")


# --- POV-Ray -------------------------------------------------------------------------------------------------


def povray() -> Peer | None:
    """Return POV-Ray; install it if necessary."""
    return _packaged("POV-Ray", "povray", "povray", "--version")


def _packaged(name: str, program: str, package: str, version: str) -> Peer | None:
    """Return a program of the system's packages; `version` makes it print its version."""
    if shutil.which(program) is None:
        _install_package(package)
    path = shutil.which(program)
    if path is None:
        leave_out(name, f"`{program}` is not there, and apt-get could not install it")
        return None
    output = subprocess.run([path, version], capture_output=True, text=True, check=False)
    numbers = re.findall(r"\d[\d.]*\.\d+", output.stdout + output.stderr)
    return Peer(path, f"{name} {max(numbers, key=len)}" if numbers else name)


def _install_package(name: str) -> bool:
    """Install a package with apt-get, as root or with a non-interactive sudo; return whether it succeeded."""
    apt_get = shutil.which("apt-get")
    if apt_get is None:
        return False
    as_root = [] if os.geteuid() == 0 else ["sudo", "--non-interactive"]
    if as_root and shutil.which("sudo") is None:
        return False
    sys.stderr.write(f"installing {name} by apt-get\n")
    update = [*as_root, apt_get, "update", "--quiet"]
    install = [*as_root, apt_get, "install", "--quiet", "--yes", "--no-install-recommends", name]
    if _succeeds(install):
        return True
    return _succeeds(update) and _succeeds(install)


def _succeeds(command: list[str]) -> bool:
    environment = {**os.environ, "DEBIAN_FRONTEND": "noninteractive"}
    return subprocess.run(command, capture_output=True, env=environment, check=False).returncode == 0


# --- Tachyon and Embree --------------------------------------------------------------------------------------


def tachyon() -> Peer | None:
    """Return Tachyon; install it if necessary."""
    return _packaged("Tachyon", "tachyon", "tachyon-bin-nox", "-version")


def embree() -> Peer | None:
    """Return `embree.cpp`, compiled; install Embree if necessary."""
    compiler, target = shutil.which("c++"), WORK / "embree"
    if compiler is None:
        leave_out("Embree", "there is no C++ compiler: `c++`")
        return None
    command = [compiler, *CPP_FLAGS, str(HERE / "embree.cpp"), "-o", str(target), "-lembree3", "-pthread"]
    if not _succeeds(command) and not (_install_package("libembree-dev") and _succeeds(command)):
        leave_out("Embree", "`embree.cpp` cannot be compiled, and apt-get could not install libembree-dev")
        return None
    return Peer(str(target), f"Embree {_first_line(str(target))}")


# --- Mitsuba -------------------------------------------------------------------------------------------------


def mitsuba() -> Peer | None:
    """Return Mitsuba 3 with a working LLVM backend; install both if necessary."""
    python = WORK / "mitsuba" / "bin" / "python"
    if not _has_mitsuba(python) and not _install_mitsuba(python):
        leave_out("Mitsuba 3", "pip could not install it")
        return None
    peer = _working_mitsuba(python)
    if peer is None and any(_install_package(name) for name in LLVM_PACKAGES):
        peer = _working_mitsuba(python)
    if peer is None:
        leave_out(
            "Mitsuba 3", "it finds no LLVM library of version 15 or newer, and apt-get could not install one"
        )
    return peer


def _has_mitsuba(python: Path) -> bool:
    return python.exists() and _succeeds([str(python), "-m", "pip", "show", "mitsuba"])


def _install_mitsuba(python: Path) -> bool:
    sys.stderr.write("installing Mitsuba 3 by pip\n")
    return _succeeds([sys.executable, "-m", "venv", str(python.parent.parent)]) and _succeeds(
        [str(python), "-m", "pip", "install", "--quiet", "--disable-pip-version-check", "mitsuba>=3.5"]
    )


def _working_mitsuba(python: Path) -> Peer | None:
    """Return Mitsuba with the LLVM library that it finds by itself, or with the first that works."""
    found = (path for pattern in LLVM_PATHS for path in sorted(glob.glob(pattern), reverse=True))  # noqa: PTH207
    for environment in ({}, *({"DRJIT_LIBLLVM_PATH": path} for path in found)):
        probe = subprocess.run(
            [str(python), "-c", PROBE],
            capture_output=True,
            text=True,
            env={**os.environ, **environment},
            check=False,
        )
        if probe.returncode == 0:
            version, llvm = probe.stdout.split()
            return Peer(str(python), f"Mitsuba {version} llvm_ad_rgb (LLVM {llvm})", environment)
    return None


# --- The kernel in C -----------------------------------------------------------------------------------------


def plain_kernel() -> Peer | None:
    """Return `brute_force.c` in portable C, vectorised by the compiler."""
    return _kernel("the kernel in plain C", "brute_force_plain", "-DPORTABLE")


def intrinsics_kernel() -> Peer | None:
    """Return `brute_force.c` with AVX-512 intrinsics, if the processor has AVX-512."""
    name = "the kernel with AVX-512 intrinsics"
    peer = _kernel(name, "brute_force")
    if peer and not peer.version.endswith(", avx512"):
        leave_out(name, "this processor has no AVX-512")
        return None
    return peer


def _kernel(name: str, program: str, *flags: str) -> Peer | None:
    """Compile the kernel with the constants of the still life; its version ends with its SIMD level."""
    compiler = shutil.which("cc")
    if compiler is None:
        leave_out(name, "there is no C compiler: `cc`")
        return None
    header, target = WORK / "still_life.h", WORK / program
    # The header does not depend on the resolution.
    header.write_text(scenes.c_header(scenes.still_life(16, 9)))
    source = str(HERE / "brute_force.c")
    command = [compiler, *C_FLAGS, *flags, "-include", str(header), source, "-o", str(target), "-lm"]
    compiled = subprocess.run(command, capture_output=True, text=True, check=False)
    if compiled.returncode != 0:
        leave_out(name, f"the compiler says\n{compiled.stderr}")
        return None
    return Peer(str(target), f"{_first_line(compiler, '--version')}, {_simd_level(target)}")


def _first_line(*command: str) -> str:
    return subprocess.run(command, capture_output=True, text=True, check=True).stdout.splitlines()[0]


def _simd_level(program: Path) -> str:
    level: str = json.loads(_first_line(str(program), "16", "9", "1", "0"))["simd"]
    return level
