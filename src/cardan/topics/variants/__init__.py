"""Studies of many variants: sampling, evaluation, statistics, Pareto front, yield."""
