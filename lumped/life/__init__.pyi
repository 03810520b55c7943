from lumped.life.rainflow import Cycles as Cycles
from lumped.life.rainflow import rainflow as rainflow
from lumped.life.sn_curve import SNCurve as SNCurve
