"""Builds the wheel: CMake compiles the module, with the core inside. CMAKE_ARGS in the environment adds arguments."""
import os
import re
import shlex
import shutil
import subprocess
import sys
from pathlib import Path

from setuptools import Extension, setup
from setuptools.command.build_ext import build_ext

ROOT = Path(__file__).resolve().parent


class CMakeBuild(build_ext):
    def build_extension(self, ext):
        build = Path(self.build_temp).resolve()
        build.mkdir(parents=True, exist_ok=True)
        options = ["-DGMS_RANSAC_ROS=OFF", "-DGMS_RANSAC_PYTHON=ON", "-DBUILD_SHARED_LIBS=OFF",
                   "-DCMAKE_BUILD_WITH_INSTALL_RPATH=ON", "-DPython_EXECUTABLE=" + sys.executable]
        try:
            import pybind11
            options.append("-Dpybind11_DIR=" + pybind11.get_cmake_dir())
        except (ImportError, AttributeError):
            pass  # CMake finds that of pybind11-dev by itself
        options += shlex.split(os.environ.get("CMAKE_ARGS", ""))
        jobs = os.environ.get("CMAKE_BUILD_PARALLEL_LEVEL", str(os.cpu_count()))
        for command in ([str(ROOT)] + options, ["--build", ".", "--target", "_gms_ransac", "--parallel", jobs]):
            subprocess.run(["cmake"] + command, cwd=str(build), check=True)
        module, = build.rglob("_gms_ransac*.so")
        target = Path(self.get_ext_fullpath(ext.name))
        target.parent.mkdir(parents=True, exist_ok=True)
        shutil.copy(str(module), str(target))


manifest = (ROOT / "package.xml").read_text()
setup(
    name="gms_ransac",
    version=re.search("<version>(.*)</version>", manifest)[1],
    description="Match filter for visual SLAM: ORB features, Grid-based Motion Statistics, RANSAC, relative pose",
    long_description=(ROOT / "README.md").read_text(encoding="utf-8"),
    long_description_content_type="text/markdown",
    license="BSD-3-Clause",
    packages=["gms_ransac"],
    package_dir={"gms_ransac": "src/python"},
    package_data={"gms_ransac": ["py.typed", "*.pyi"]},
    ext_modules=[Extension("gms_ransac._gms_ransac", [])],
    cmdclass={"build_ext": CMakeBuild},
    install_requires=["numpy"],
    python_requires=">=3.8",
    zip_safe=False,
)
