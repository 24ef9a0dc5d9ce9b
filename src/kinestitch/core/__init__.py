"""What a motion is: rotations, skeletons, motions, their world poses, their frame rates and their mirror image."""
