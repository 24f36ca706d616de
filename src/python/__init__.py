"""The pipeline, without ROS: MatchFilter, match, estimate, Camera, Features, MatchResult, Status. An installation with ROS also has
the messages and parameters of the nodelet (gms_ransac.msg, gms_ransac.cfg)."""
from importlib import import_module

__all__ = ["Camera", "Features", "MatchFilter", "MatchResult", "Status", "estimate", "match"]


def __getattr__(name):
    # On first use, so that a program that only reads messages does not load OpenCV.
    if name not in __all__:
        raise AttributeError("module 'gms_ransac' has no attribute '%s'" % name)
    try:
        return getattr(import_module("._gms_ransac", __name__), name)
    except ModuleNotFoundError:
        raise ImportError("gms_ransac was built without its Python module; install pybind11-dev and build again") from None


def __dir__():
    return sorted(list(globals()) + __all__)
