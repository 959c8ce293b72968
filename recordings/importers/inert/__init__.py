"""Reading pickles as data: nothing a pickle asks for is called, imported or allocated unseen."""
