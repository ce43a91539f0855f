from conrod.comparison import *  # temporary
