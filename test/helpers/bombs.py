"""Small files that state, or hold, enormous images."""
import struct
import zlib

import cv2
import numpy as np

SIDE = 20000        # pixels, width and height of each


def png(width=SIDE, height=SIDE):
    """Return a valid PNG of 1 bit per pixel, all black."""
    def chunk(name, data):
        return (struct.pack('>I', len(data)) + name + data
                + struct.pack('>I', zlib.crc32(name + data)))
    rows = zlib.compressobj(1)
    row = bytes(1 + (width + 7) // 8)
    data = b''.join([rows.compress(row * height), rows.flush()])
    return (b'\x89PNG\r\n\x1a\n' + chunk(b'IHDR', struct.pack('>IIBBBBB', width, height, 1, 0, 0,
                                                              0, 0))
            + chunk(b'IDAT', data) + chunk(b'IEND', b''))


def lying_png(name=b'IDAT'):
    """Return a small PNG one of whose chunks states a length of 2 GB."""
    data = _encoded('.png')
    start = data.index(b'IDAT') - 4
    return data[:start] + b'\x7f\xff\xff\xff' + name + data[start + 8:]


def jpeg(width=SIDE, height=SIDE):
    """Return a JPEG whose data ends early: OpenCV fills the rest with grey."""
    data = _encoded('.jpg')
    frame = data.index(b'\xff\xc0') + 5
    return data[:frame] + struct.pack('>HH', height, width) + data[frame + 4:]


def lying_jp2():
    """Return a JPEG 2000 of 10x10 pixels whose codestream has 12000x12000."""
    data = _encoded('.jp2')
    box, siz = data.index(b'ihdr') + 4, data.index(b'\xff\x4f\xff\x51') + 8
    data = data[:siz] + struct.pack('>6I', 12000, 12000, 0, 0, 12000, 12000) + data[siz + 24:]
    return data[:box] + struct.pack('>II', 10, 10) + data[box + 8:]


def tiff_of_two_sizes(first, last):
    """Return a grey TIFF of first x first pixels that states last x last pixels after that."""
    data = zlib.compress(bytes(first * first))
    entries = [(256, 4, first), (256, 4, last), (257, 4, first), (257, 4, last), (258, 3, 8),
               (259, 3, 8), (262, 3, 1), (273, 4, 0), (277, 3, 1), (278, 4, first),
               (279, 4, len(data))]
    start = 8 + 2 + 12 * len(entries) + 4
    return (b'II*\0' + struct.pack('<IH', 8, len(entries))
            + b''.join(struct.pack('<HHII', tag, kind, 1, start if tag == 273 else value)
                       for tag, kind, value in entries) + bytes(4) + data)


def headers():
    """Return images of other formats by their extension; only the headers are enormous."""
    bmp, tiff, webp, raster = map(_encoded, ('.bmp', '.tiff', '.webp', '.ras'))
    jp2 = _encoded('.jp2')
    box = jp2.index(b'ihdr') + 4
    size = struct.pack('>II', SIDE, SIDE)
    for tag in (256, 257):      # ImageWidth, ImageLength of TIFF 6.0
        entry = next(struct.pack('<HHI', tag, kind, 1) for kind in (3, 4)
                     if struct.pack('<HHI', tag, kind, 1) in tiff)
        start = tiff.index(entry)
        tiff = tiff[:start] + struct.pack('<HHII', tag, 4, 1, SIDE) + tiff[start + 12:]
    # VP8L: a signature, then 14 bits for width - 1 and 14 bits for height - 1
    bits = 16383 - 1 | 16383 - 1 << 14
    return {
        'bmp': bmp[:18] + struct.pack('<ii', SIDE, SIDE) + bmp[26:],
        'jp2': jp2[:box] + size + jp2[box + 8:],
        'jpg': jpeg(),
        'pgm': 'P5 {0} {0} 255\n'.format(SIDE).encode(),
        'ppm': 'P6 {0} {0} 255\n'.format(SIDE).encode(),
        'ras': raster[:4] + size + raster[12:],
        'tiff': tiff,
        'webp': webp[:21] + struct.pack('<I', bits) + webp[25:],
    }


def _encoded(extension):
    flags = [cv2.IMWRITE_WEBP_QUALITY, 101] if extension == '.webp' else []     # lossless
    return cv2.imencode(extension, np.zeros((64, 64, 3), np.uint8), flags)[1].tobytes()
