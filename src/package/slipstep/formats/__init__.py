"""Files of other programs: slip models and patches of faults, read and written, in the frame of this project. READERS
has a line for each kind."""
