"""The programs of output/, one each: arguments, and main()."""
