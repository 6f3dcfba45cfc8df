"""The node usb_cam."""
