"""Result for people: what a solver said, with the instance it is about; drawn and tabled in a notebook."""

from __future__ import annotations

import html
import io
from dataclasses import dataclass, fields
from pathlib import Path
from typing import TYPE_CHECKING

from formulations.routing.solver import Result as Claim
from instances import Instance, tour_costs

if TYPE_CHECKING:
    import pandas as pd
    from matplotlib.figure import Figure


@dataclass(frozen=True, kw_only=True)
class Result(Claim):
    """How a solve ended (`formulations.routing.solver.Result`), checked, and the instance it is about.

    Parameters
    ----------
    instance
        What was solved; tasks are 0..n-1 in `routes`, and ``instance.provenance["labels"]`` names the nodes where they
        had names.
    solver
        The name it was solved by.
    """

    instance: Instance
    solver: str

    @classmethod
    def of(cls, claim: Claim, instance: Instance, solver: str) -> Result:
        """Return a solver's result with what it is about."""
        return cls(**{each.name: getattr(claim, each.name) for each in fields(Claim)}, instance=instance, solver=solver)

    @property
    def tours(self) -> pd.DataFrame:
        """A row a UAV: uav (from 0), depot, cost [s], tasks in flying order; empty where there are no routes."""
        import pandas as pd

        routes = self.routes or ()
        labels = self.instance.provenance.get("labels") or list(range(self.instance.n_nodes))
        return pd.DataFrame(
            {
                "uav": range(len(routes)),
                "depot": [labels[depot] for depot in self.instance.depots][: len(routes)],
                "cost": tour_costs(self.instance, routes) if routes else [],
                "tasks": [[labels[task] for task in route] for route in routes],
            }
        )

    def plot(self) -> Figure:
        """Return the tours on the map beside bars of their costs.

        Returns
        -------
        matplotlib.figure.Figure
            Costs in seconds, positions in kilometres.

        Raises
        ------
        ValueError
            Where there are no routes.
        """
        from reports.figures.routes import draw_routes

        if self.routes is None:
            raise ValueError(f"there are no routes to draw: {self.summary()}")
        return draw_routes(self.instance, self.routes)

    def write(self, path: Path | str) -> None:
        """Write the routes as ``.sol``.

        Parameters
        ----------
        path
            Its name; ``workbench check`` reads it.

        Raises
        ------
        ValueError
            Where there are no routes.
        """
        from instances.files import write_routes

        if self.routes is None:
            raise ValueError(f"there are no routes to write: {self.summary()}")
        write_routes(self.routes, self.instance, Path(path))

    def _repr_html_(self) -> str:
        """Return the routes drawn and their table, for notebooks."""
        name, told = html.escape(self.instance.name), html.escape(f"{self.solver}: {self.summary()}")
        words = f"<p><b>{name}</b>, {told}</p>"
        if self.routes is None:
            return words + f"<p>{html.escape(self.message)}</p>"
        picture = io.StringIO()
        self.plot().savefig(picture, format="svg")
        table = self.tours.to_html(index=False, float_format="{:.6g}".format)
        return words + picture.getvalue()[picture.getvalue().index("<svg") :] + table
