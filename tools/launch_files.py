"""The arguments of launch files, for ./run demo and for the page doc/launch.md: it is printed."""
import collections
import os
import sys
import xml.etree.ElementTree as ElementTree

_HEAD = """# Launch files

The arguments of each launch file in `launch/`. `./run demo --help` lists those of the demo, or
without `./run`, `roslaunch --ros-args img_recog demo.launch`. `demo.launch` starts the parts below
it and hands its arguments to them; on the command line, it takes those of the parts too
(`./run demo web_port:=8090`). A launch file of your own that includes it and sets an argument of a
part needs `<include ... pass_all_args="true">`. Each part works alone:
`roslaunch img_recog simulator.launch`. This page is printed by

    python3 tools/launch_files.py > doc/launch.md
"""

Argument = collections.namedtuple('Argument', 'name default doc group')
# default: None if there is none; group: the comment above it


def read(path):
    """Return the root element of a launch file."""
    parser = ElementTree.XMLParser(target=ElementTree.TreeBuilder(insert_comments=True))
    return ElementTree.parse(path, parser).getroot()


def arguments(root):
    """Return the arguments of a launch file, by name; of alternatives (if, unless), the first."""
    found, group = {}, ''
    for each in root:
        if each.tag is ElementTree.Comment:
            group = each.text.strip()
        elif each.tag == 'arg' and each.get('value') is None:
            found.setdefault(each.get('name'), Argument(
                each.get('name'), each.get('default'), each.get('doc'), group))
    return found


def with_parts(path):
    """Return the root elements of a launch file and of those that it includes, by file name."""
    roots = {os.path.basename(path): read(path)}
    for each in roots[os.path.basename(path)].iter('include'):
        part = os.path.basename(each.get('file'))
        roots[part] = read(os.path.join(os.path.dirname(path), part))
    return roots


def taken(roots):
    """Return the arguments that a launch file takes, by name; roots: of `with_parts`."""
    found = {}
    for name, root in roots.items():
        group = 'more of ' + name if found else None
        for argument in arguments(root).values():
            found.setdefault(argument.name, argument._replace(group=group or argument.group))
    return found


def page(folder):
    """Yield the lines of doc/launch.md."""
    yield from _HEAD.splitlines()
    roots = with_parts(os.path.join(folder, 'demo.launch'))
    for name in (*roots, 'robot.launch', 'machines.launch'):
        root = roots.get(name) or read(os.path.join(folder, name))
        yield from ('', '## ' + name, '')
        if name != 'demo.launch':
            yield from (' '.join(next(root.iter(ElementTree.Comment)).text.split()), '')
        yield from ('| argument | default | meaning |', '|---|---|---|')
        for each in arguments(root).values():
            default = {None: 'required', '': 'empty'}.get(
                each.default, '`{}`'.format(each.default))
            yield '| `{}` | {} | {} |'.format(each.name, default, each.doc)


if __name__ == '__main__':
    LAUNCH = os.path.join(os.path.dirname(os.path.abspath(__file__)), '..', 'launch')
    sys.stdout.write('\n'.join(page(LAUNCH)) + '\n')
