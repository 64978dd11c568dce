"""Episodes: one drop of an object, looks by a policy, one attempt of a grasp."""
