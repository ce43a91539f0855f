"""Two hundred inputs of ten kinds, half of them wrong: does conrod say what is wrong, and only that?"""
