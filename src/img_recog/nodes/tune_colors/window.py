"""A window that shows a picture, by tkinter."""
from typing import Callable, Optional

import numpy as np

from img_recog.errors import UserError, one_line

_MAX_SCREEN_SHARE = 0.9
_RESIZE_DELAY_MS = 100      # a window that is being resized is redrawn when it stops changing


class WindowError(UserError):
    """The window cannot be opened."""


class PictureWindow:
    """Shows a picture as large as fits, until the window is closed (also by Escape or q).

    A plain label shows the image that matplotlib would write to a file. In matplotlib's own window
    texts overlap when it is made smaller, and it needs another package.

    is_open: whether the window has not been closed yet.
    """

    def __init__(self, title: str, width: int, height: int):
        """Open the window with width x height pixels, or fewer if the screen is smaller.

        Raises WindowError if tkinter is missing or the display cannot be reached.
        """
        try:
            import tkinter  # a separate package that may be missing
        except ImportError as error:
            raise WindowError('no window: tkinter cannot be loaded: {}; install python3-tk'.format(
                one_line(error)))
        try:
            self._root = tkinter.Tk(className=title)
        except tkinter.TclError as error:
            raise WindowError('no window: {}'.format(error))
        self._tkinter = tkinter
        self.is_open = True
        scale = min(1.0, _MAX_SCREEN_SHARE * self._root.winfo_screenwidth() / width,
                    _MAX_SCREEN_SHARE * self._root.winfo_screenheight() / height)
        self._root.title(title)
        self._root.geometry('{}x{}'.format(int(width * scale), int(height * scale)))
        self._label = tkinter.Label(self._root, background='white', borderwidth=0)
        self._label.place(relwidth=1, relheight=1)
        self._root.protocol('WM_DELETE_WINDOW', self.close)
        for key in ('<Escape>', 'q'):
            self._root.bind(key, lambda _: self.close())
        self._label.bind('<Configure>', self._on_resize)
        self._render: Optional[Callable[[int, int], np.ndarray]] = None
        self._redraw_id: Optional[str] = None
        self._photo: Optional['tkinter.PhotoImage'] = None
        self._root.update()

    def show(self, render: Callable[[int, int], np.ndarray]) -> None:
        """Show another picture.

        render: returns it, uint8 rgb8, so that it fits into a width and a height in pixels.
        """
        self._render = render
        if self.is_open:
            self._draw()

    def update(self) -> None:
        """Process the events of the window; to be called often."""
        if self.is_open:
            self._root.update()

    def wait(self) -> None:
        """Process the events of the window until it is closed."""
        if self.is_open:
            self._root.mainloop()

    def close(self) -> None:
        """Close the window, if it is open."""
        if self.is_open:
            self.is_open = False
            self._root.destroy()

    def _on_resize(self, _) -> None:
        if self._redraw_id is not None:
            self._root.after_cancel(self._redraw_id)
        self._redraw_id = self._root.after(_RESIZE_DELAY_MS, self._draw)

    def _draw(self) -> None:
        if self._render is None:
            return
        image = self._render(self._label.winfo_width(), self._label.winfo_height())
        header = 'P6 {1} {0} 255 '.format(*image.shape[:2]).encode()
        photo = self._tkinter.PhotoImage(master=self._root, format='PPM',
                                         data=header + image.tobytes())
        self._label.configure(image=photo)
        self._photo = photo     # tkinter keeps no reference, and the label would become empty
