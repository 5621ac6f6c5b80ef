"""Packs the extension that cargo has built and the package around it as a wheel.

    python3 pack.py LIBRARY FOLDER

`maturin build` makes the same wheel, but compiles everything once more on its way.
"""

import base64
import hashlib
import sys
import sysconfig
import tomllib
import zipfile
from pathlib import Path

HERE = Path(__file__).parent
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


def main(library: Path, out: Path) -> Path:
    """Writes the wheel; its path."""
    project = tomllib.loads((HERE / "pyproject.toml").read_text())["project"]
    version = tomllib.loads((HERE / "../../Cargo.toml").read_text())["workspace"]["package"]["version"]
    platform = sysconfig.get_platform().replace("-", "_").replace(".", "_")
    name, tag = project["name"], f"cp311-abi3-{platform}"
    info = f"{name}-{version}.dist-info"
    source = HERE / "python"
    contents = {str(path.relative_to(source)): path.read_bytes() for path in package(source / name)}
    contents[f"{name}/_{name}.abi3.so"] = library.read_bytes()
    contents[f"{info}/METADATA"] = metadata(project, version).encode()
    contents[f"{info}/WHEEL"] = f"Wheel-Version: 1.0\nGenerator: pack.py\nRoot-Is-Purelib: false\nTag: {tag}\n".encode()
    for licence in sorted((HERE / "../..").glob("LICENSE-*")):
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
            entry.external_attr = 0o644 << 16
            archive.writestr(entry, data, zipfile.ZIP_DEFLATED)
    return wheel


if __name__ == "__main__":
    print(main(Path(sys.argv[1]), Path(sys.argv[2])))
