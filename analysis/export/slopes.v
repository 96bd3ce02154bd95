(* ---- Slope bounds, and what they say of an integral ---- *)

Definition sloped (odds : bool) (l k : R) (phi : R -> R) : Prop :=
  phi 0 = 0 /\ slopes_in l k phi /\ (odds = true -> odd phi).
Lemma slopes_sector : forall odds l k phi, sloped odds l k phi -> in_sector l k phi.
Proof.
  intros odds l k phi [Z [S _]]; split; [exact Z|]; intro y.
  destruct (Rtotal_order 0 y) as [P|[<-|N]]; [pose proof (S 0 y P)|lra|pose proof (S y 0 N)]; rewrite Z in *; nra.
Qed.

Lemma tangent : forall F f, (forall y, derivable_pt_lim F y (f y)) -> (forall s t, s < t -> f s <= f t) ->
  forall x y, F y + f y * (x - y) <= F x.
Proof.
  intros F f D up x y; destruct (Rtotal_order x y) as [L|[->|L]]; [|lra|];
    [destruct (MVT_cor2 F f x y L) as [c [E C]]|destruct (MVT_cor2 F f y x L) as [c [E C]]]; auto;
    [pose proof (up c y ltac:(lra))|pose proof (up y c ltac:(lra))]; nra.
Qed.
Lemma integral_between : forall odds (Phi phi : R -> R) l k y p, sloped odds l k phi -> l < k ->
  integral_of Phi phi -> phi y = p ->
  l / 2 * (y * y) + / (2 * (k - l)) * ((p - l * y) * (p - l * y)) <= Phi y <=
  l / 2 * (y * y) + (p - l * y) * y - / (2 * (k - l)) * ((p - l * y) * (p - l * y)).
Proof.
  intros odds Phi phi l k y p [Z [S _]] lk [Z' D] <-.
  assert (low : forall x y, Phi y - l / 2 * y ^ 2 + (phi y - l * y) * (x - y) <= Phi x - l / 2 * x ^ 2).
  { apply (tangent (fun y => Phi y - l / 2 * y ^ 2) (fun y => phi y - l * y)); [|intros s t L; pose proof (S s t L); lra].
    intro u; apply (derivable_pt_lim_minus Phi (fun y => l / 2 * y ^ 2)); [apply D|].
    replace (l * u) with (l / 2 * (INR 2 * u ^ 1)) by (simpl; field); apply derivable_pt_lim_scal, derivable_pt_lim_pow. }
  assert (high : forall x y, k / 2 * y ^ 2 - Phi y + (k * y - phi y) * (x - y) <= k / 2 * x ^ 2 - Phi x).
  { apply (tangent (fun y => k / 2 * y ^ 2 - Phi y) (fun y => k * y - phi y)); [|intros s t L; pose proof (S s t L); lra].
    intro u; apply (derivable_pt_lim_minus (fun y => k / 2 * y ^ 2) Phi); [|apply D].
    replace (k * u) with (k / 2 * (INR 2 * u ^ 1)) by (simpl; field); apply derivable_pt_lim_scal, derivable_pt_lim_pow. }
  set (q := phi y - l * y) in *; set (d := q / (k - l)).
  replace (/ (2 * (k - l)) * (q * q)) with (q * d - (k - l) / 2 * (d * d)) by (unfold d; field; lra).
  assert (E : (k - l) * d = q) by (unfold d; field; lra).
  pose proof (high (y - d) y) as A; pose proof (low (y - d) 0) as B; pose proof (high d 0) as T; pose proof (low d y) as G.
  replace (phi y) with (q + l * y) in A, G by (unfold q; ring); rewrite Z, Z' in *.
  assert (E2 : (k - l) * (d * d) = q * d) by (rewrite <- E; ring); split; nra.
Qed.
