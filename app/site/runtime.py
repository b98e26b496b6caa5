"""The runtime of a page without a server: two files of the npm package onnxruntime-web.

A folder that holds them is taken as it is; else npm fetches the pinned version once, and the cache
keeps it. Both ways, the page serves them itself: nothing comes from another host.
"""

import shutil
import subprocess
import tarfile
from hashlib import sha256
from pathlib import Path
from tempfile import TemporaryDirectory

from omnivat.kit.errors import DataError
from omnivat.kit.files import cache_folder, replacing

PACKAGE, VERSION = "onnxruntime-web", "1.30.0"
FILES = {  # SHA-256 of the pinned version
    "ort.wasm.bundle.min.mjs": "11e64bd8ffe11bd1a2a2f0d6275fdfbbba7262f0b76b99b53d228a8a22ef3d90",
    "ort-wasm-simd-threaded.wasm": (
        "3398c10d07d229bd91b364548e130e0e51a8e5704b88c7c083ebbeb78842dee2"
    ),
}
FETCH_S = 300


def write_runtime(folder: Path, runtime: Path | None = None) -> None:
    """Copy the runtime into `folder`: of the folder `runtime`, or of the pinned version.

    Raises DataError if `runtime` lacks a file, or the package cannot be fetched whole.
    """
    source = (
        _fetched()
        if runtime is None
        else runtime / "dist"
        if (runtime / "dist").is_dir()
        else runtime
    )
    folder.mkdir(parents=True, exist_ok=True)
    for name in FILES:
        if not (source / name).is_file():
            raise DataError(
                f"'{source}' holds no {name}; name the folder of the npm package {PACKAGE}."
            )
        with replacing(folder / name) as file:
            shutil.copyfile(source / name, file)


def _fetched() -> Path:
    kept = cache_folder() / "runtime" / VERSION
    if all((kept / name).is_file() for name in FILES):
        return kept
    npm = shutil.which("npm")
    if npm is None:
        raise _unreachable("npm is not installed")
    with TemporaryDirectory(prefix="omnivat-runtime-") as folder:
        pack = [npm, "pack", f"{PACKAGE}@{VERSION}", "--silent", "--pack-destination", folder]
        try:
            subprocess.run(pack, check=True, capture_output=True, timeout=FETCH_S)
        except (subprocess.SubprocessError, OSError) as error:
            raise _unreachable("npm could not fetch it") from error
        with tarfile.open(next(Path(folder).glob("*.tgz"))) as package:
            for name, wanted in FILES.items():
                member = package.extractfile(f"package/dist/{name}")
                content = member.read() if member else b""
                if sha256(content).hexdigest() != wanted:
                    raise _unreachable(f"{name} is not the file of that version")
                with replacing(kept / name) as file:
                    file.write_bytes(content)
    return kept


def _unreachable(why: str) -> DataError:
    return DataError(
        f"A site needs the runtime {PACKAGE} {VERSION}, and {why}. Fetch that package elsewhere,"
        " and name its folder with --runtime."
    )
