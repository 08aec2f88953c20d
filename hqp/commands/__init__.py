"""The commands of ``hqp`` that need no robot, a file each; what they need is imported when they are called."""
