from conrod.comparison import *  # temporary
from conrod.comparison import QUANTITIES, Comparison, Closure, ErrorSeries, PointErrors, Size, size_of, compare
