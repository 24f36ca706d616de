"""The pipeline, without ROS: MatchFilter, match, estimate, Camera, Features, RotationPrior, MatchResult, Triangulation, Status. An installation with ROS also has
the messages and parameters of the nodelet (gms_ransac.msg, gms_ransac.cfg)."""
from importlib import import_module

__all__ = ["Camera", "Features", "MatchFilter", "MatchResult", "RotationPrior", "Status", "Triangulation", "estimate", "match"]


def __getattr__(name):
    # On first use, so that a program that only reads messages does not load OpenCV.
    if name not in __all__:
        raise AttributeError("module 'gms_ransac' has no attribute '%s'" % name)
    try:
        return getattr(import_module("._gms_ransac", __name__), name)
    except ModuleNotFoundError as error:
        if error.name != __name__ + "._gms_ransac":
            raise  # such as numpy
        raise ImportError("gms_ransac has its messages and no '%s': it was built without pybind11. Install pybind11-dev "
                          "(rosdep install does) and build the workspace again" % name) from None


def __dir__():
    return sorted(list(globals()) + __all__)
