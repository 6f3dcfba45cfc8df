#!/usr/bin/env python3
"""Place the demo's windows side by side if there is no window manager.

Without one, X shows every window in the upper left corner, the simulator's on top of the images.
Neither image_view (OpenCV's highgui) nor PyBullet has an option for the position of its window.
Ends when all windows stay where they are placed, and immediately if a window manager is running.

usage: place_windows.py [ARGUMENT:=VALUE ...], the arguments of demo.launch.
"""
import ctypes
import ctypes.util
import signal
import sys
import time

from img_recog import process_tree

SIMULATOR = 'Bullet Physics'
# the ends of their titles, which begin with the namespace of the demo
IMAGES = ('/usb_cam/image_raw', '/blue_image', '/red_image')
# a part of the title of each window that an argument of demo.launch opens
OPTIONAL = {'rviz': ' - RViz', 'rqt_graph': 'rqt_graph__', 'rqt_reconfigure': 'rqt_reconfigure__'}
GAP_PX = 4
_POLL_PERIOD_S = 0.3
_PATIENCE_S = 300.0
_STABLE_S = 3.0
_SUBSTRUCTURE_REDIRECT = 1 << 20        # X.h; window managers select it on the root
_IS_VIEWABLE = 2                        # X.h
_STEP_PX = 40                           # between windows for which there is no free place

_Window, _Pointer = ctypes.c_ulong, ctypes.c_void_p


class Attributes(ctypes.Structure):
    """XWindowAttributes of Xlib.h."""

    _fields_ = [
        *((name, ctypes.c_int) for name in ('x', 'y', 'width', 'height', 'border', 'depth')),
        ('visual', _Pointer), ('root', _Window),
        *((name, ctypes.c_int) for name in ('kind', 'bit_gravity', 'win_gravity', 'backing')),
        ('backing_planes', ctypes.c_ulong), ('backing_pixel', ctypes.c_ulong),
        ('save_under', ctypes.c_int), ('colormap', ctypes.c_ulong),
        ('map_installed', ctypes.c_int), ('map_state', ctypes.c_int),
        ('all_event_masks', ctypes.c_long), ('your_event_mask', ctypes.c_long),
        ('do_not_propagate_mask', ctypes.c_long), ('override_redirect', ctypes.c_int),
        ('screen', _Pointer)]


class Display:
    """The part of Xlib that is needed here."""

    def __init__(self):
        """Connect to $DISPLAY; raise OSError if that fails."""
        self._xlib = ctypes.CDLL(ctypes.util.find_library('X11') or 'libX11.so.6')
        self._xlib.XOpenDisplay.restype = _Pointer
        self._xlib.XDefaultRootWindow.restype = _Window
        # a window may be closed between two calls; by default Xlib exits the program then
        handler = ctypes.CFUNCTYPE(ctypes.c_int, _Pointer, _Pointer)
        self._ignore = handler(lambda display, event: 0)
        self._xlib.XSetErrorHandler(self._ignore)
        self._display = _Pointer(self._xlib.XOpenDisplay(None))
        if not self._display:
            raise OSError('no display')
        self.root = self._xlib.XDefaultRootWindow(self._display)

    def attributes(self, window):
        """Return the Attributes of a window, all 0 if it does not exist."""
        result = Attributes()
        self._xlib.XGetWindowAttributes(self._display, _Window(window), ctypes.byref(result))
        return result

    def windows(self):
        """Return a dict from the title of each window on the display to its id."""
        root, parent, number = _Window(), _Window(), ctypes.c_uint()
        children = ctypes.POINTER(_Window)()
        self._xlib.XQueryTree(self._display, _Window(self.root), ctypes.byref(root),
                              ctypes.byref(parent), ctypes.byref(children), ctypes.byref(number))
        found = {}
        for window in [children[index] for index in range(number.value)]:
            name = ctypes.c_char_p()
            self._xlib.XFetchName(self._display, _Window(window), ctypes.byref(name))
            if name.value:
                found[name.value.decode(errors='replace')] = window
        return found

    def move(self, window, left_px, top_px):
        """Move the upper left corner of a window there, and raise the window."""
        self._xlib.XMoveWindow(self._display, _Window(window), left_px, top_px)
        self._xlib.XRaiseWindow(self._display, _Window(window))
        self._xlib.XSync(self._display, 0)


def places(screen, sizes):
    """Return the upper left corner of each window, by title.

    The simulator, the images right of it, and the others where there is room. screen: (width,
    height) in pixels. sizes: the same of each window, by title. If the screen is too small, the
    windows overlap, but none is off screen.
    """
    result, left, top = {}, 0, 0
    for title in filter(lambda title: title.startswith(SIMULATOR), sizes):
        result[title] = (0, 0)
        left = sizes[title][0] + GAP_PX
    for title in (title for name in IMAGES for title in sizes if title.endswith(name)):
        width, height = sizes[title]
        result[title] = (max(0, min(left, screen[0] - width)),
                         max(0, min(top, screen[1] - height)))
        top += height + GAP_PX
    for part in OPTIONAL.values():
        for title in filter(lambda title: part in title, sizes):
            taken = [(*place, *sizes[other]) for other, place in result.items()]
            result[title] = free_place(screen, sizes[title], taken)
    return result


def free_place(screen, size, taken):
    """Return the leftmost place where a window covers no other.

    Where there is none, the place where it covers the smallest share of any other window.
    taken: the others, as left, top, width and height.
    """
    room = [max(0, screen[axis] - size[axis]) for axis in (0, 1)]
    lefts, tops = ({min(room[axis], edge) for edge in (
        0, room[axis], *(each[axis] + each[axis + 2] + GAP_PX for each in taken))}
        for axis in (0, 1))
    best = min(((left, top) for left in lefts for top in tops), key=lambda place: (
        max((covered_share(place, size, each) for each in taken), default=0), place))
    left, top = best
    while (left, top) in {each[:2] for each in taken} and (left or top):
        left, top = max(0, left - _STEP_PX), max(0, top - _STEP_PX)
    return left, top


def covered_share(place, size, other):
    """Return the share of another window, (left, top, width, height), that a window covers."""
    width, height = (
        max(0, min(place[axis] + size[axis], other[axis] + other[axis + 2])
            - max(place[axis], other[axis])) for axis in (0, 1))
    return width * height / max(1, other[2] * other[3])


def parts_of_titles(*words):
    """Return a part of the title of each window that the demo opens with these arguments."""
    wanted = [part for name, part in OPTIONAL.items()
              if {name + ':=true', name + ':=1'} & set(words)]
    return (SIMULATOR, *IMAGES, *wanted)


def main(*words):
    """Place the windows of a demo with these arguments, when they appear."""
    signal.signal(signal.SIGINT, signal.SIG_DFL)
    process_tree.end_with_parent()
    try:
        display = Display()
    except OSError:
        return 0
    wanted = parts_of_titles(*words)
    root = display.attributes(display.root)
    stable_s = end = time.monotonic() + _PATIENCE_S
    while time.monotonic() < end and not root.all_event_masks & _SUBSTRUCTURE_REDIRECT:
        windows = {title: window for title, window in display.windows().items()
                   if any(part in title for part in wanted)}
        attributes = {title: display.attributes(window) for title, window in windows.items()}
        sizes = {title: (found.width, found.height) for title, found in attributes.items()
                 if found.map_state == _IS_VIEWABLE}
        wrong = {title: place
                 for title, place in places((root.width, root.height), sizes).items()
                 if (attributes[title].x, attributes[title].y) != place}
        for title, place in wrong.items():
            display.move(windows[title], *place)
        # a program may move its window again while it opens it
        if wrong or len(sizes) < len(wanted):
            stable_s = time.monotonic() + _STABLE_S
        elif time.monotonic() > stable_s:
            return 0
        time.sleep(_POLL_PERIOD_S)
    return 0


if __name__ == '__main__':
    sys.exit(main(*sys.argv[1:]))
