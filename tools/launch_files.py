"""The arguments of launch files, for ./run demo and for the page doc/launch.md."""
import collections
import os
import xml.etree.ElementTree as ElementTree

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


def head(root):
    """Return the comment at the head of a launch file."""
    return ' '.join(next(root.iter(ElementTree.Comment)).text.split())
