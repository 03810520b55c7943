from lumped.explorer.explore import Explorer as Explorer
from lumped.explorer.explore import explore as explore
