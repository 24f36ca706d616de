"""module_folder.py PREFIX: prints the folder below PREFIX in which this Python looks for modules, relative to it."""
import os
import site
import sys

prefix = os.path.join(os.path.realpath(sys.argv[1]), "")
found = [path[len(prefix):] for path in map(os.path.realpath, sys.path + site.getsitepackages())
         if path.startswith(prefix) and os.path.basename(path) in ("dist-packages", "site-packages")]
print(min(found, key=len, default="lib/python3/dist-packages"))
