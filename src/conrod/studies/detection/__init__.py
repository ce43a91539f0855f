"""Detection of defects: does a verdict notice defects of known size that are planted?"""
