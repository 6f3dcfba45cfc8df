"""Check the imports between the folders of the package in its syntax trees."""
import ast
import functools
import pathlib

PURE = ('camera', 'formats', 'recognition', 'rendering', 'simulation', 'teleoperation')
GROUND_FLOOR = ('camera_arguments', 'command_line', 'errors', 'files', 'loading', 'model',
                'processes', 'report', 'rotations', 'settings')
# the rooms of simulation/, from the lowest to the highest: none imports one above it
SIMULATION_ROOMS = ('simulation_settings', 'wheels', 'physics', 'sensors',
                    'configured_model', 'simulated_model', 'guard', 'simulator', 'pictures',
                    'models', 'pacing', 'assembly')
# libraries that only some folders or files may use
OWNERS = {
    **dict.fromkeys(('pybullet', 'pybullet_data', 'pybullet_utils'), (
        'simulation/physics', 'simulation/sensors', 'simulation/pictures')),
    'moderngl': ('rendering',),
    **dict.fromkeys(('collada', 'trimesh'), ('formats/meshes',)),
    **dict.fromkeys(('dask', 'distributed'), ('batch',)),
    **dict.fromkeys(('fastapi', 'nicegui', 'starlette', 'uvicorn'), ('nodes/web',))}
# of rospy's objects
PRIVATE_ATTRIBUTES = ('impl', '_connection_header', '_invoke_callback')
ROS_SUFFIXES = ('_msgs', '_srvs')
ROS_LIBRARIES = ('actionlib', 'camera_info_manager', 'catkin', 'cv_bridge', 'diagnostic_updater',
                 'dynamic_reconfigure', 'genmsg', 'genpy', 'image_geometry', 'image_transport',
                 'laser_geometry', 'message_filters', 'nodelet', 'tf', 'tf2_ros', 'tf_conversions')
# for each part of img_recog, the other parts that it may use
ALLOWED = {
    **{folder: ('camera_arguments', 'errors', 'files', 'formats', 'model', 'report', 'rotations',
                'settings') + (('processes',) if folder == 'simulation' else ())
       for folder in PURE},
    'command_line': ('errors', 'processes'),
    '__init__': (), 'errors': (), 'processes': ('camera_arguments', 'errors'),
    'camera_arguments': ('settings',), 'rotations': (),
    'model': ('rotations',), 'report': ('errors',), 'files': ('errors',), 'settings': ('errors',),
    'loading': ('conversions', 'errors', 'files', 'formats', 'settings', 'simulation'),
    'ros': ('errors', 'processes', 'settings'),
    'conversions': PURE + ('errors', 'rotations', 'settings'),
    'recordings': PURE + GROUND_FLOOR + ('conversions',),
    'replay': PURE + GROUND_FLOOR + ('conversions', 'recordings', 'ros'),
    'batch': PURE + GROUND_FLOOR + ('conversions', 'recordings', 'replay'),
    'checks': PURE + GROUND_FLOOR + ('conversions',),
    'doctor': ('command_line', 'errors', 'ros'),
    'graph': ('command_line', 'errors', 'files', 'processes', 'ros'),
    'nodes': PURE + GROUND_FLOOR + ('conversions', 'graph', 'ros'),
    'testing': GROUND_FLOOR + ('conversions', 'recognition', 'replay', 'ros'),
}
WITHOUT_RCLIENT = PURE + GROUND_FLOOR + ('batch', 'checks', 'conversions', 'doctor', 'graph',
                                         'recordings', 'replay')


def violations(package):
    """Return a line for each forbidden import or name in the folder `package`."""
    return [line for path in sorted(pathlib.Path(package).rglob('*.py'))
            for line in _of_file(path, path.relative_to(package))]


def _of_file(path, name):
    imports, internals = _read(path, name)
    for line, module in imports:
        reason = _reason(name, module)
        if reason:
            yield '{}:{}: {}: {}'.format(name, line, module, reason)
    if name.parts[:2] != ('ros', 'transport'):
        for line, text in internals:
            yield '{}:{}: {}: internals of rospy are only for ros/transport'.format(
                name, line, text)


@functools.lru_cache(maxsize=None)
def _read(path, name):
    """Return line number and name of each import in a file, and of each use of internals."""
    nodes = list(ast.walk(ast.parse(path.read_text(), str(path))))
    return list(_imports(nodes, name)), list(_internals(nodes))


def _imports(nodes, name):
    """Yield line number and absolute name of each import in the file, also of relative ones."""
    package = ('img_recog',) + name.parts[:-1]
    for node in nodes:
        if isinstance(node, ast.Import):
            for alias in node.names:
                yield node.lineno, alias.name
        elif isinstance(node, ast.ImportFrom):
            base = package[:len(package) - node.level + 1] if node.level else ()
            module = '.'.join(base + ((node.module,) if node.module else ()))
            for alias in node.names:
                yield node.lineno, '{}.{}'.format(module, alias.name)
        elif isinstance(node, ast.Call) and _called(node) == 'import_module':
            for word in node.args[:1]:
                if isinstance(word, ast.Constant):
                    yield node.lineno, word.value


def _internals(nodes):
    rospy_names = set(_names_of_rospy(nodes))
    for node in nodes:
        if isinstance(node, ast.Attribute):
            parts = _dotted(node)
            is_private = any(part.startswith('_') for part in parts[1:])
            if node.attr in PRIVATE_ATTRIBUTES or is_private and parts[0] in rospy_names:
                yield node.lineno, '.'.join(parts)
        elif isinstance(node, ast.ImportFrom) and (node.module or '').split('.')[0] == 'rospy':
            for alias in node.names:
                if alias.name.startswith(('_', '*')) or 'impl' in (
                        node.module + '.' + alias.name):
                    yield node.lineno, '{}.{}'.format(node.module, alias.name)
        elif isinstance(node, ast.Import):
            for alias in node.names:
                if alias.name.startswith('rospy.impl'):
                    yield node.lineno, alias.name


def _names_of_rospy(nodes):
    """Yield the names that a file gives to rospy and to what it imports from rospy."""
    for node in nodes:
        if isinstance(node, ast.Import):
            for alias in node.names:
                if alias.name.split('.')[0] == 'rospy':
                    yield alias.asname or 'rospy'
        elif isinstance(node, ast.ImportFrom) and (node.module or '').split('.')[0] == 'rospy':
            for alias in node.names:
                yield alias.asname or alias.name


def _called(node):
    return getattr(node.func, 'attr', getattr(node.func, 'id', ''))


def _dotted(node):
    parts = []
    while isinstance(node, ast.Attribute):
        parts.append(node.attr)
        node = node.value
    parts.append(node.id if isinstance(node, ast.Name) else '')
    return parts[::-1]


def _reason(name, module):
    """Return why a file may not import a module, None if it may."""
    part = name.parts[0][:-3] if len(name.parts) == 1 else name.parts[0]
    if part not in ALLOWED:
        return '{} is not a part of the package that the walls know'.format(part)
    library, _, rest = module.partition('.')
    if library == 'img_recog':
        return _reason_within(name, part, rest.split('.'))
    owners = OWNERS.get(library)
    if owners is not None and not any(_is_in(name, owner) for owner in owners):
        return 'only {} may use {}'.format(', '.join(owners), library)
    if library == 'rospy' and part in WITHOUT_RCLIENT:
        return '{} runs without a node'.format(part)
    is_ros = (library.startswith('ros') or library in ROS_LIBRARIES
              or library.endswith(ROS_SUFFIXES))
    if is_ros and part in PURE + ('__init__', 'errors', 'files', 'settings'):
        return '{} must not use ROS'.format(part)
    return None


def _is_in(name, place):
    """Return whether a file is in a folder, or is the file with that name without .py."""
    return place in (name.with_suffix('').as_posix(), *(
        parent.as_posix() for parent in name.parents))


def _reason_within(name, part, target):
    if (target[0] == 'ros' and part in WITHOUT_RCLIENT and part != 'doctor'
            and target[1] != 'timed_xmlrpc'):
        return '{} may use only timed_xmlrpc of ros'.format(part)
    if target[:3] == ['ros', 'transport', 'outbox'] and part != 'ros':
        return 'outbox is for ros/transport alone'
    if target[0] == part:
        node = name.parts[1].replace('.py', '') if len(name.parts) > 1 else ''
        if part == 'nodes' and target[1] not in (node, 'compressed_images'):
            return 'a node does not import another'
        if part == 'simulation' and len(name.parts) > 1 and name.parts[1] != '__init__.py':
            return _reason_of_rooms(name.parts[1].replace('.py', ''), target[1])
        return None
    if target[0] not in ALLOWED.get(part, ()):
        return '{} may use {} of this package'.format(
            part, ', '.join(sorted(ALLOWED.get(part, ()))) or 'nothing else')
    return None


def _reason_of_rooms(room, target):
    for each in (room, target):
        if each not in SIMULATION_ROOMS:
            return '{} is not a room of simulation that the walls know'.format(each)
    if SIMULATION_ROOMS.index(target) > SIMULATION_ROOMS.index(room):
        return '{} is above {}'.format(target, room)
    return None


def circles(package):
    """Return the circles of imports: lists of files, or of folders, that import one another."""
    package = pathlib.Path(package)
    files = {path.relative_to(package) for path in package.rglob('*.py')}
    arrows = {name: set() for name in files}
    for name in files:
        for _, module in _read(package / name, name)[0]:
            parts = module.split('.')[1:] if module.startswith('img_recog.') else []
            target = next((path for path in (pathlib.PurePath(*parts[:length]).with_suffix('.py')
                                             for length in range(len(parts), 0, -1))
                           if path in files), None)
            if target is not None and target != name:
                arrows[name].add(target)
    return _rings(arrows) + _rings(_of_folders(arrows))


def _of_folders(arrows):
    """Return the arrows between folders, or to a file beside a folder."""
    between = {}
    for name, targets in arrows.items():
        for target in targets:
            depth = next(number for number, (mine, other) in enumerate(zip(
                name.parts, target.parts)) if mine != other)
            mine, other = (pathlib.PurePath(*path.parts[:depth + 1]) for path in (name, target))
            between.setdefault(mine, set()).add(other)
    return between


def _rings(arrows):
    """Return each set of places from which one comes back, sorted, as text."""
    reached = {}
    for start in arrows:
        found, waiting = set(), list(arrows[start])
        while waiting:
            place = waiting.pop()
            if place not in found:
                found.add(place)
                waiting += arrows.get(place, ())
        reached[start] = found
    return sorted({' '.join(sorted(other.as_posix() for other in reached[place]
                                   if place in reached.get(other, ())))
                   for place in reached if place in reached[place]})
