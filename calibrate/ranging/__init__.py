"""How far away a surface is that fills a zone, from its histogram."""

from calibrate.ranging.ranges import Ranges, ranges
from calibrate.ranging.templates import Templates, plane_templates

__all__ = ["Ranges", "Templates", "plane_templates", "ranges"]
