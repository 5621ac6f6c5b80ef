"""Packs the extension and the program that cargo has built, and the package around them, as a wheel.

    python3 pack.py LIBRARY PROGRAM FOLDER

This is the one way in which a wheel is made: `cargo xtask test` tests it, `cargo xtask python wheel` releases it.
"""

import base64
import hashlib
import re
import sys
import sysconfig
import tomllib
import zipfile
from pathlib import Path

HERE = Path(__file__).parent
LICENCES = sorted((HERE / "../..").glob("LICENSE-*"))
# Fixed, so that equal contents make equal wheels.
TIME = (1980, 1, 1, 0, 0, 0)


def metadata(project: dict, version: str) -> str:
    """The core metadata."""
    lines = [
        "Metadata-Version: 2.4",
        f"Name: {project['name']}",
        f"Version: {version}",
        f"Summary: {project['description']}",
        f"License-Expression: {project['license']}",
        f"Requires-Python: {project['requires-python']}",
        *(f"Requires-Dist: {needed}" for needed in project["dependencies"]),
    ]
    for extra, needs in project["optional-dependencies"].items():
        lines.append(f"Provides-Extra: {extra}")
        lines += [f"Requires-Dist: {needed}; extra == '{extra}'" for needed in needs]
    lines += [f"Project-URL: {name}, {address}" for name, address in project.get("urls", {}).items()]
    lines += [f"Classifier: {what}" for what in project.get("classifiers", [])]
    lines += [f"License-File: {licence.name}" for licence in LICENCES]
    readme = (HERE / project["readme"]).read_text()
    return "\n".join([*lines, "Description-Content-Type: text/markdown", "", readme])


def package(folder: Path) -> list[Path]:
    """The files of the package, those behind links too."""
    found = []
    for entry in sorted(folder.iterdir()):
        if entry.is_dir():
            found += [] if entry.name == "__pycache__" else package(entry)
        elif entry.suffix in {".py", ".pyi", ".toml", ".csv", ".urdf", ".typed"} or entry.name == "py.typed":
            found.append(entry)
    return found


def platform(*binaries: bytes) -> str:
    """The platform of the wheel. On Linux the newest version of glibc that the binaries name decides (PEP 600)."""
    here = sysconfig.get_platform().replace("-", "_").replace(".", "_")
    if not here.startswith("linux_"):
        return here
    versions = [int(minor) for binary in binaries for minor in re.findall(rb"GLIBC_2\.(\d+)", binary)]
    return f"manylinux_2_{max([17, *versions])}_{here.removeprefix('linux_')}"


def main(library: Path, program: Path, out: Path) -> Path:
    """Writes the wheel; its path."""
    project = tomllib.loads((HERE / "pyproject.toml").read_text())["project"]
    version = tomllib.loads((HERE / "../../Cargo.toml").read_text())["workspace"]["package"]["version"]
    extension, script = library.read_bytes(), program.read_bytes()
    name, tag = project["name"], f"cp310-abi3-{platform(extension, script)}"
    info = f"{name}-{version}.dist-info"
    source = HERE / "python"
    contents = {str(path.relative_to(source)): path.read_bytes() for path in package(source / name)}
    contents[f"{name}/_{name}{'.pyd' if library.suffix == '.dll' else '.abi3.so'}"] = extension
    contents[f"{name}-{version}.data/scripts/{program.name}"] = script
    contents[f"{info}/METADATA"] = metadata(project, version).encode()
    contents[f"{info}/WHEEL"] = f"Wheel-Version: 1.0\nGenerator: pack.py\nRoot-Is-Purelib: false\nTag: {tag}\n".encode()
    for licence in LICENCES:
        contents[f"{info}/licenses/{licence.name}"] = licence.read_bytes()
    record = ""
    for path, data in contents.items():
        digest = base64.urlsafe_b64encode(hashlib.sha256(data).digest()).rstrip(b"=").decode()
        record += f"{path},sha256={digest},{len(data)}\n"
    contents[f"{info}/RECORD"] = (record + f"{info}/RECORD,,\n").encode()
    out.mkdir(parents=True, exist_ok=True)
    wheel = out / f"{name}-{version}-{tag}.whl"
    with zipfile.ZipFile(wheel, "w", zipfile.ZIP_DEFLATED) as archive:
        for path, data in contents.items():
            entry = zipfile.ZipInfo(path, TIME)
            entry.external_attr = (0o100755 if ".data/scripts/" in path else 0o100644) << 16
            archive.writestr(entry, data, zipfile.ZIP_DEFLATED)
    return wheel


if __name__ == "__main__":
    print(main(*map(Path, sys.argv[1:])))
