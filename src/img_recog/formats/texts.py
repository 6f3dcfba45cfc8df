"""The names and texts of XML elements, which may lack them."""
import xml.etree.ElementTree as ElementTree
from typing import Optional


def name_of(element: ElementTree.Element) -> str:
    """Return the attribute `name`, '' if there is none."""
    return element.get('name', '')


def text_of(element: ElementTree.Element, path: str) -> str:
    """Return the text of the first element at a path, without spaces around it; '' if it has none.

    >>> text_of(ElementTree.fromstring('<link><mass> 2 </mass></link>'), 'mass')
    '2'
    """
    return element.findtext(path, '').strip()


def is_true(text: Optional[str]) -> bool:
    """Return whether the text of an element means true."""
    return (text or '').strip().lower() in ('1', 'true')
