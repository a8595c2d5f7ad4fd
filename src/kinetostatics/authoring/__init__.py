"""Robot files from the notation of parallel mechanisms, such as ``3-R[P]S``, or from a plain URDF."""
