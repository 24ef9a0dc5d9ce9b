"""One rig to another: where the hips are, which joints correspond, how big the body is."""
