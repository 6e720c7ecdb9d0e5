"""Works out what the columns of a foreign log are, and in which unit, from what they tell of one and the same motion.

Open `recognise.py` first. Nothing here is taken over in silence: `dvp map` writes what was found, with its evidence.
"""
