#!/usr/bin/env python3
"""check_arguments.py [NAME VALUE CHOICE...]: refuses what roslaunch takes in silence. Launch files run it while they are
read; with an error roslaunch prints its sentence and starts nothing. It looks at the command line of the roslaunch that
runs it: an argument that the launch file does not have is an error. So is a VALUE of NAME that is neither empty nor a
CHOICE. So is rviz without a display."""
import difflib
import os
import sys
import xml.etree.ElementTree as ElementTree

# Options with which roslaunch prints and starts nothing.
PRINTS = ("--ros-args", "--dump-params", "--files", "--nodes", "--args", "--find-node")
HERE = os.path.dirname(os.path.realpath(__file__))


def launch_folders():
    """Our launch files: next to scripts/ in the source, in share/ of an installation."""
    return [os.path.join(HERE, "../launch"), os.path.join(HERE, "../../share/gms_ransac/launch")]


def named_on(words):
    """(our launch file, names of the arguments) of a command line; None if roslaunch was given another file."""
    given = [word.split(":=")[0] for word in words if ":=" in word]
    for word in words:
        for folder in launch_folders():
            file = os.path.join(folder, os.path.basename(word))
            ours = "gms_ransac" in words or (os.path.exists(word) and os.path.exists(file) and os.path.samefile(word, file))
            if word.endswith(".launch") and ours and os.path.exists(file):
                return file, given
    return None


def wants_rviz(words, file):
    """Whether the command line, or the default of the launch file, opens rviz."""
    given = [word.split(":=")[1] for word in words if word.startswith("rviz:=")]
    if os.path.basename(file) == "view.launch":
        return True
    defaults = [arg.get("default") for arg in ElementTree.parse(file).getroot().findall("arg") if arg.get("name") == "rviz"]
    return (defaults + given)[-1].lower() in ("true", "1") if defaults else False


def check(words, choice):
    if choice:
        name, value, *choices = choice
        if value and value not in choices:
            return "%s is '%s'; it must be %s or empty" % (name, value, ", ".join(choices))
    named = named_on(words)
    if named is None:
        return ""
    file, given = named
    known = [arg.get("name") for arg in ElementTree.parse(file).getroot().findall("arg") if arg.get("value") is None]
    for name in given:
        if not name.startswith("__") and name not in known:
            near = difflib.get_close_matches(name, known, 1)
            return "%s has no argument %s%s; it has %s" % (os.path.basename(file), name,
                                                           ", did you mean %s" % near[0] if near else "", ", ".join(known))
    # Checks of launch files, which start nothing, have no display either.
    starts = any(os.path.basename(word) == "roslaunch" for word in words) and not any(map(lambda word: word.startswith(PRINTS), words))
    if starts and not os.environ.get("DISPLAY") and wants_rviz(words, file):
        return "rviz needs a display and there is none: give rviz:=false, or run it in one (xvfb-run -a roslaunch ...)"
    return ""


if __name__ == "__main__":
    with open("/proc/%d/cmdline" % os.getppid()) as command:
        problem = check(command.read().split("\0"), sys.argv[1:])
    if problem:
        sys.exit(problem)
    print("checked", end="")  # the value of the launch file's parameter
