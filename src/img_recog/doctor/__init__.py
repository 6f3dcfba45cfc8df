"""What is wrong with the machine and the running system, and what to do; doctor.py."""
