"""The fixture `simulation`."""
pytest_plugins = ['img_recog.testing.fixtures']
