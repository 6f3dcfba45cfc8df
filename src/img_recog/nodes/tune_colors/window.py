"""A window on a picture, by tkinter."""
from typing import Callable, Optional

import numpy as np

from img_recog.errors import UserError

_SCREEN_SHARE = 0.9
_SETTLED_MS = 100


class WindowError(UserError):
    """There can be no window."""


class PictureWindow:
    """Shows a picture as large as fits, until it is closed (also by Escape or q).

    What is shown is what matplotlib would write into a file, in a plain label: matplotlib's own
    window would let the words overlap when it is made smaller, and needs one more package.

    is_open: whether it has not been closed yet.
    """

    def __init__(self, title: str, width: int, height: int):
        """Open the window, of width x height pixels if the screen has as many.

        Raises WindowError when tkinter is missing or the display cannot be reached.
        """
        try:
            import tkinter  # a package of its own that may be missing
        except ImportError:
            raise WindowError('no window: Python has no tkinter here; install python3-tk')
        try:
            self._root = tkinter.Tk(className=title)
        except tkinter.TclError as error:
            raise WindowError('no window: {}'.format(error))
        self._tkinter = tkinter
        self.is_open = True
        scale = min(1.0, _SCREEN_SHARE * self._root.winfo_screenwidth() / width,
                    _SCREEN_SHARE * self._root.winfo_screenheight() / height)
        self._root.title(title)
        self._root.geometry('{}x{}'.format(int(width * scale), int(height * scale)))
        self._label = tkinter.Label(self._root, background='white', borderwidth=0)
        self._label.place(relwidth=1, relheight=1)
        self._root.protocol('WM_DELETE_WINDOW', self.close)
        for key in ('<Escape>', 'q'):
            self._root.bind(key, lambda _: self.close())
        self._label.bind('<Configure>', self._resized)
        self._render: Optional[Callable[[int, int], np.ndarray]] = None
        self._redrawing, self._photo = None, None
        self._root.update()

    def show(self, render: Callable[[int, int], np.ndarray]) -> None:
        """Show a picture from now on.

        render: makes it, uint8 rgb8, to fit into a width and a height in pixels.
        """
        self._render = render
        if self.is_open:
            self._draw()

    def update(self) -> None:
        """Do what the user has asked for since the last call; to be called often."""
        if self.is_open:
            self._root.update()

    def wait(self) -> None:
        """Return when the window has been closed."""
        if self.is_open:
            self._root.mainloop()

    def close(self) -> None:
        """Close the window; harmless when repeated."""
        if self.is_open:
            self.is_open = False
            self._root.destroy()

    def _resized(self, _) -> None:
        if self._redrawing is not None:
            self._root.after_cancel(self._redrawing)
        self._redrawing = self._root.after(_SETTLED_MS, self._draw)

    def _draw(self) -> None:
        if self._render is None:
            return
        image = self._render(self._label.winfo_width(), self._label.winfo_height())
        header = 'P6 {1} {0} 255 '.format(*image.shape[:2]).encode()
        # kept: tkinter does not, and the label would be empty
        self._photo = self._tkinter.PhotoImage(master=self._root, format='PPM',
                                               data=header + image.tobytes())
        self._label.configure(image=self._photo)
