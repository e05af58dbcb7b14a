"""What the figures show beside results, and how pictures are made."""

from dataclasses import dataclass

from stages.biped.quantity import Bound, parameter
from stages.comparison.claims.paper import Limits
from stages.ground.blocks import Blocks
from stages.ground.contact_law import OnGround
from stages.twin.parameters import Settings as Twin


@dataclass(frozen=True)
class Settings(Limits):
    """The paper's limits, and the pictures' resolution."""

    resolution_dpi: int = parameter("1/inch", "resolution of the PNG figures", bound=Bound(minimum=50, maximum=1200))
    pdf: bool = parameter("-", "whether each figure is a PDF as well")


@dataclass(frozen=True)
class Parameters(OnGround):
    """Parameters of the figures."""

    twin: Twin
    settings: Settings
    blocks: Blocks = Blocks()
