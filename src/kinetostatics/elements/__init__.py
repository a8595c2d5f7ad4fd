"""Elastic elements of robots: beams, elastic joints and actuators, each with the answers to the questions of all solvers."""
