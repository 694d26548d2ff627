"""The contact algorithms: unilateral contact with clearance or interference, friction, bolted assemblies."""
