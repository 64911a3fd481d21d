"""build.py: makes a wheel, or a source archive, of the package pbw with a C compiler and Python's own library.

    pip install ./examples/python            # from the source tree: no network, where NumPy is installed
    python3 examples/python/build.py DIST    # the wheel alone, into the folder DIST, without pip

CC and CFLAGS come from the environment; with PBW_CUDA=1 there, nvcc (NVCC) builds pbw_cuda.cu into the library, for
device="cuda".  The wheel fits every Python 3 of this machine's kind, for the library is
loaded by ctypes.  Headers are read from the source tree, or from beside this file in a source archive.
"""
import base64
import glob
import hashlib
import io
import os
import re
import shlex
import shutil
import subprocess
import sys
import sysconfig
import tarfile
import tempfile
import zipfile

HERE = os.path.dirname(os.path.abspath(__file__))
LIBRARY = "libpbw_python.so"
SOURCES = "pbw_python.c", "pbw_queries.c", "pbw_domains.c", "pbw_gpu.c"
METADATA = """Metadata-Version: 2.1
Name: pbw
Version: %s
Summary: Exact Delaunay and regular triangulations in 2D and 3D, with the interface of scipy.spatial.Delaunay
License: MIT-0
Requires-Python: >=3.8
Requires-Dist: numpy
"""


def _header(name="pbw.h", folder=""):
    """The path of a header: of a source archive, or in that folder of the source tree."""
    for path in (os.path.join(HERE, name), os.path.join(HERE, "..", "..", folder, name)):
        if os.path.exists(path):
            return path
    raise SystemExit("%s is neither beside build.py nor two folders up: install from the whole source tree" % name)


def _headers():
    names = ("pbw_check.h", "pbw_query.h", "pbw_live.h", "pbw_cells.h", "pbw_mesh2.h", "pbw_adapt2.h",
             "pbw_surface.h", "pbw_improve.h", "pbw_mesh3.h", "pbw_fill.h", "pbw_wrap.h")
    return (_header(), *(_header(name, os.path.join("examples", "lib")) for name in names))


def _read(path):
    with open(path, "rb") as file:
        return file.read()


def _version():
    text = _read(_header()).decode()
    return ".".join(re.search(r"define PBW_VERSION_%s (\d+)" % part, text).group(1)
                    for part in ("MAJOR", "MINOR", "PATCH"))


def _modules():
    """The package's files: name in the wheel, bytes."""
    paths = sorted(glob.glob(os.path.join(HERE, "pbw", "*.py")))
    return [("pbw/" + os.path.basename(path), _read(path)) for path in paths]


def _compile_cuda(folder):
    """What the C compiler links, and how, for a library with pbw_cuda.cu; nothing without PBW_CUDA=1."""
    if os.environ.get("PBW_CUDA", "0") in ("", "0"):
        return []
    compiler = os.environ.get("NVCC") or shutil.which("nvcc") or "/usr/local/cuda/bin/nvcc"
    source, target = _header("pbw_cuda.cu"), os.path.join(folder, "cuda.o")
    command = [compiler, "-O3", "-Xcompiler", "-fPIC", *("-I" + os.path.dirname(path) for path in _headers()),
               "-c", source, "-o", target]
    print(shlex.join(command))
    try:
        subprocess.run(command, check=True)
    except FileNotFoundError:
        raise SystemExit("PBW_CUDA=1: %s is not there; set NVCC" % compiler) from None
    except subprocess.CalledProcessError as e:
        raise SystemExit("nvcc failed: %s" % e) from None
    libraries = os.path.join(os.path.dirname(os.path.dirname(os.path.realpath(shutil.which(compiler)))), "lib64")
    return ["-DPBW_CUDA", target, "-L" + libraries, "-lcudart_static", "-lstdc++", "-ldl", "-lrt"]


def _compile():
    """The bytes of the shared library."""
    compiler = shlex.split(os.environ.get("CC") or "cc")
    flags = ["-std=c99", "-O2", *shlex.split(os.environ.get("CFLAGS", "")), "-fPIC", "-shared"]
    with tempfile.TemporaryDirectory() as folder:
        target = os.path.join(folder, LIBRARY)
        command = [*compiler, *flags, *("-I" + os.path.dirname(path) for path in _headers()),
                   *(os.path.join(HERE, name) for name in SOURCES), "-o", target, *_compile_cuda(folder), "-lpthread",
                   "-lm"]
        print(shlex.join(command))
        try:
            subprocess.run(command, check=True)
        except FileNotFoundError:
            raise SystemExit("no C compiler: %s is not there; set CC" % compiler[0]) from None
        except subprocess.CalledProcessError as e:
            raise SystemExit("the C compiler failed: %s" % e) from None
        return _read(target)


def _platform():
    """The last part of the wheel's name: linux_x86_64, macosx_11_0_arm64."""
    name = re.sub(r"^(macosx-\d+)-", r"\1.0-", sysconfig.get_platform())
    return re.sub("[-.]", "_", name)


def build_wheel(wheel_directory, config_settings=None, metadata_directory=None):
    version, tag = _version(), "py3-none-" + _platform()
    info = "pbw-%s.dist-info/" % version
    wheel = "Wheel-Version: 1.0\nGenerator: build.py\nRoot-Is-Purelib: false\nTag: %s\n" % tag
    files = [*_modules(), ("pbw/" + LIBRARY, _compile()), (info + "METADATA", (METADATA % version).encode()),
             (info + "WHEEL", wheel.encode())]
    record = ""
    for name, data in files:
        digest = base64.urlsafe_b64encode(hashlib.sha256(data).digest()).rstrip(b"=").decode()
        record += "%s,sha256=%s,%d\n" % (name, digest, len(data))
    files.append((info + "RECORD", (record + info + "RECORD,,\n").encode()))
    name = "pbw-%s-%s.whl" % (version, tag)
    with zipfile.ZipFile(os.path.join(wheel_directory, name), "w", zipfile.ZIP_DEFLATED) as archive:
        for path, data in files:
            entry = zipfile.ZipInfo(path)              # of 1980: the same files make the same wheel
            entry.external_attr = (0o100755 if path.endswith(".so") else 0o100644) << 16
            archive.writestr(entry, data, zipfile.ZIP_DEFLATED)
    return name


def build_sdist(sdist_directory, config_settings=None):
    version = _version()
    files = [(name, _read(os.path.join(HERE, name)))
             for name in ("build.py", "pyproject.toml", "pbw_python.h", *SOURCES)]
    files += [*((os.path.basename(path), _read(path)) for path in _headers()),
              ("PKG-INFO", (METADATA % version).encode()), *_modules()]
    name = "pbw-%s.tar.gz" % version
    with tarfile.open(os.path.join(sdist_directory, name), "w:gz", format=tarfile.PAX_FORMAT) as archive:
        for path, data in files:
            entry = tarfile.TarInfo("pbw-%s/%s" % (version, path))
            entry.size = len(data)
            archive.addfile(entry, io.BytesIO(data))
    return name


if __name__ == "__main__":
    if len(sys.argv) != 2:
        raise SystemExit("usage: build.py FOLDER")
    os.makedirs(sys.argv[1], exist_ok=True)
    print(build_wheel(sys.argv[1]))
