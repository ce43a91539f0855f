"""The commands of the command line, a module each; they load what they need when they run."""
