"""How results lie in HDF5: so that netCDF readers, pandas and MATLAB see names, units, dimensions and tables."""
