"""The program replay: a video or a bag through recognition and simulation, without a master."""
