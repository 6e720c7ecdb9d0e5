"""Reads CommonRoad scenarios (XML, 2018b and 2020a) as what the rest of the product knows: OpenDRIVE and OpenSCENARIO.

Begin with `source.py`, which says what a file holds; `roads.py` makes roads of its lanelets, `story.py` a storyboard of
its obstacles and planning problem. Source: M. Althoff, M. Koschi, S. Manzinger, CommonRoad: Composable benchmarks for
motion planning on roads, IEEE Intelligent Vehicles Symposium 2017, and the documentation of the format, 2020a.
"""
