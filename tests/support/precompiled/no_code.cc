// Nothing of its own: a target that precompiles headers must have a source.
